//! Parts of a bench. `@NAME@` stands for what differs between benches.

pub(super) const OPTIONS: &str = "\
// Options: +gaps=P  sources and sink pause in about P % of the clocks, in bursts (default 0)
//          +seed=N  another pattern of pauses (default 1)
//          +dump    write all signals; +dump=FILE into that file
// The last line says PASS or FAIL; the exit status of FAIL is not 0. Without gaps, the cycles of
// every job and all counters are compared too. Jobs:
";

pub(super) const BEGIN: &str = r#"`timescale 1ns/1ps
`default_nettype none

module @UNIT@_tb;
  localparam JOBS = @JOBS@;
  localparam RESET = 0, BEGIN = 1, RUN = 2, DRAIN = 3, DONE = 4, SCRIPT = 5;
  localparam CLOSED = 160;  // clocks in which the sink of every second job takes nothing

  reg clk = 1'b0;
  always #5 clk = ~clk;
  reg rst_n = 1'b0;
  reg cfg_clear = 1'b0;

  integer gaps;
  integer seed;
  integer state = RESET;
  integer job = 0;
  integer clocks = 0;  // in this state
  reg is_fresh = 1'b0;  // nothing since reset
  integer cycles = 0;  // of this job
  integer quiet = 0;   // clocks since a beat moved
  integer cut = 0;     // cycle of the first job in which it is cut off by a reset
  integer reset = 4;   // clocks of a reset; one is enough
  integer resets = 0;  // that have cut the first job off
  reg failed = 1'b0;
  reg moved;
  reg willing;
  reg closed;          // the sink takes nothing, and the sources do not pause

  // Pauses are drawn from an xorshift generator, so that all simulators draw the same.
  reg [31:0] drawn = 32'd1;
  function [31:0] after(input [31:0] x);
    begin
      after = x ^ (x << 13);
      after = after ^ (after >> 17);
      after = after ^ (after << 5);
    end
  endfunction
  // Percentage of pauses of a stream for some clocks: none, usual or most.
  function integer rate(input [1:0] kind);
    begin
      case (kind)
        2'd0: rate = 0;
        2'd1: rate = gaps == 0 ? 0 : (100 + gaps) / 2;
        default: rate = gaps;
      endcase
    end
  endfunction
"#;

pub(super) const SOURCE: &str = r#"  integer @IN@_at = 0;
  integer @IN@_next;
  integer @IN@_rate = 0;
  reg @IN@_open = 1'b0;
  integer @IN@_packets = 0;
  integer @IN@_beats = 0;  // given in all jobs
  reg @IN@_tvalid = 1'b0;
  wire @IN@_tready;
@SCRIPTED@  wire [@WIDTH@-1:0] @IN@_word = @CHOICE@@IN@_words[@IN@_at < @COUNT@ ? @IN@_at : 0];
  // While a source is not valid, its payload is inverted: a unit must not take it.
"#;

pub(super) const SINK: &str = r#"  integer @OUT@_at = 0;
  integer @OUT@_beats = 0;  // taken in all jobs
  integer @OUT@_rate = 0;
  integer @OUT@_packets = 0;
  reg @OUT@_held = 1'b0;
  reg @OUT@_tready = 1'b0;
  wire @OUT@_tvalid;
"#;

pub(super) const FAIL: &str = r#"
  task fail;
    begin
      if (!failed && state != RESET)
        $display("  job %0d, cycle %0d, +gaps=%0d +seed=%0d", job, cycles, gaps, seed);
      failed = 1'b1;
      state = DONE;
`ifdef __ICARUS__
      $finish_and_return(1);
`else
      $fatal(1);
`endif
    end
  endtask

  task pass;
    begin
      $display("PASS: @UNIT@, %0d beats in %0d jobs, +gaps=%0d +seed=%0d",
        @OUT@_beats, JOBS, gaps, seed);
      failed = 1'b1;
      state = DONE;
      $finish(0);
    end
  endtask

  reg [@WIDEST@:0] found;
  reg [@WIDEST@:0] wanted;
  integer low;
  integer lowest = 0;  // a variable: a loop from a constant fails in Verilator 5.006
  task differs(input [8*8-1:0] field);
    begin
      low = lowest;
      while (low < @WIDEST@ - 31 && found[low +: 32] === wanted[low +: 32]) low = low + 32;
      if (found[low +: 16] === wanted[low +: 16]) low = low + 16;
      $display("FAIL: beat %0d: @OUT@_%0s[%0d +: 16] is %h, expected %h",
        @OUT@_at, field, low, found[low +: 16], wanted[low +: 16]);
      fail;
    end
  endtask
"#;

pub(super) const COMPARE: &str = r#"
  task compare;
    begin
"#;

pub(super) const COMPARE_FIELD: &str = r#"      if (!failed && @OUT@_@FIELD@ !== wanted_@FIELD@) begin
        found = @OUT@_@FIELD@;
        wanted = wanted_@FIELD@;
        differs("@FIELD@");
      end
"#;

pub(super) const IDLE: &str = r#"
  wire idle;
  task check_idle;
    begin
      if (!failed && state != RESET && state != SCRIPT && idle !== 1'b0
          && (idle !== 1'b1 || @OUT@_tvalid || @OWED@)) begin
        $display("FAIL: idle is %b while there is work inside", idle);
        fail;
      end
    end
  endtask
"#;

pub(super) const COUNTERS: &str = r#"
  // After a job: counters, flags, cycles, and beats that were not taken.
  task check_job;
    begin
      if (!failed && gaps == 0 && cycles != job_cycles) begin
        $display("FAIL: %0d cycles, expected %0d", cycles, job_cycles);
        fail;
      end
"#;

pub(super) const COUNTER: &str = r#"      if (!failed && @WHEN@@STAT@ !== job_@STAT@) begin
        $display("FAIL: @STAT@ is %0d, expected %0d", @STAT@, job_@STAT@);
        fail;
      end
"#;

pub(super) const ALL_TAKEN: &str = r#"      if (!failed && @IN@_at != job_@IN@_end) begin
        $display("FAIL: %0d beats of @IN@ were not taken", job_@IN@_end - @IN@_at);
        fail;
      end
"#;

pub(super) const PROCESS: &str = r#"
  always @(posedge clk) if (!failed) begin
    clocks = clocks + 1;
    quiet = quiet + 1;
    if (state == RUN) cycles = cycles + 1;
"#;

pub(super) const RESET: &str = r#"    if (!failed && state != RESET && state != SCRIPT) begin
      if (@OUT@_tvalid !== 1'b0 && @OUT@_tvalid !== 1'b1) begin
        $display("FAIL: @OUT@_tvalid is %b", @OUT@_tvalid);
        fail;
      end else if (@OUT@_held && !@OUT@_tvalid) begin
        $display("FAIL: @OUT@_tvalid fell before beat %0d was taken", @OUT@_at);
        fail;
      end else if (@OUT@_tvalid && state != RUN) begin
        $display("FAIL: a surplus beat of @OUT@ after beat %0d", @OUT@_at);
        fail;
      end else if (@OUT@_tvalid) begin
        compare;
      end
      @OUT@_held = @OUT@_tvalid && !@OUT@_tready;
      if (@OUT@_tvalid && @OUT@_tready) begin
        @OUT@_at = @OUT@_at + 1;
        @OUT@_beats = @OUT@_beats + 1;
        if (@OUT@_tlast === 1'b1) @OUT@_packets = @OUT@_packets + 1;
        quiet = 0;
      end
    end
    case (state)
      RESET: begin
        // All inputs but reset may have any value.
        if (clocks > 2 && @OUT@_tvalid !== 1'b0) begin
          $display("FAIL: @OUT@_tvalid is %b in reset", @OUT@_tvalid);
          fail;
        end
"#;

pub(super) const RESET_SOURCE: &str = r#"        if (!failed && clocks > 1 && @IN@_tready !== 1'b0) begin
          $display("FAIL: @IN@_tready is %b in reset", @IN@_tready);
          fail;
        end
"#;

pub(super) const BEGIN_JOB: &str = r#"        if (!failed && clocks == reset) begin
          rst_n <= 1'b1;
          state = BEGIN;
          clocks = 0;
          is_fresh = 1'b1;
        end
      end
      BEGIN: begin
        if (clocks == 1) begin
@FRESH@          is_fresh = 1'b0;
          @OUT@_at = job_@OUT@_from;
          cfg_clear <= 1'b1;
"#;

/// Counters and flags after a reset, before they are cleared.
pub(super) const FRESH: &str = r#"          if (!failed && is_fresh && @STAT@ !== 0) begin
            $display("FAIL: @STAT@ is %0d after reset", @STAT@);
            fail;
          end
"#;

pub(super) const CLEAR: &str = r#"        end else if (clocks == 2) begin
          cfg_clear <= 1'b0;
        end else begin
"#;

pub(super) const CLEARED: &str = r#"          if (!failed && @STAT@ !== 0) begin
            $display("FAIL: @STAT@ is %0d after cfg_clear", @STAT@);
            fail;
          end
"#;

pub(super) const RUN: &str = r#"          if (!failed) state = RUN;
          clocks = 0;
          cycles = 0;
          quiet = 0;
        end
      end
      RUN: begin
        if (@OUT@_at == job_@OUT@_end) begin
          state = DRAIN;
          clocks = 0;
        end else if (quiet > @PATIENCE@) begin
          $display("FAIL: nothing moved for %0d clocks before beat %0d", quiet, @OUT@_at);
          fail;
        end
      end
"#;

pub(super) const IS_IDLE: &str = r#"          if (!failed && idle !== 1'b1) begin
            $display("FAIL: idle is %b after the job", idle);
            fail;
          end
"#;

pub(super) const DRAIN: &str = r#"      DRAIN: begin
        if (clocks == 40) begin
          check_job;
@IS_IDLE@          if (!failed && job + 1 == JOBS) begin
@AFTER@          end else if (!failed) begin
            job = job + 1;
            state = BEGIN;
            clocks = 0;
          end
        end
      end
      default: ;
    endcase

    closed = state == RUN && cycles < (gaps == 0 ? job_closed : job % 2 == 1 ? CLOSED : 0);
"#;

pub(super) const OFFER: &str = r#"    moved = rst_n && @IN@_tvalid && @IN@_tready === 1'b1;
    if (moved) begin
      quiet = 0;
      @IN@_beats = @IN@_beats + 1;
      @IN@_open = !@IN@_tlast;
      if (@IN@_tlast) @IN@_packets = @IN@_packets + 1;
    end
    drawn = after(drawn);
    if (clocks % 32 == 1) @IN@_rate = rate(drawn[9:8]);
    drawn = after(drawn);
    willing = closed || drawn[30:8] % 100 >= @IN@_rate;
    @IN@_next = state == BEGIN && clocks == 1 ? job_@IN@_from : @IN@_at + (moved ? 1 : 0);
    @IN@_at <= @IN@_next;
    @IN@_tvalid <= state == RUN && @IN@_next < job_@IN@_end
      && (willing || (@IN@_tvalid && !moved));
"#;

pub(super) const ACCEPT: &str = r#"    drawn = after(drawn);
    if (clocks % 32 == 1) @OUT@_rate = rate(drawn[9:8]);
    drawn = after(drawn);
    willing = !closed && drawn[30:8] % 100 >= @OUT@_rate;
    @OUT@_tready <= state == DRAIN || state == SCRIPT || (state == RUN && willing);

    // Resets of one clock in the middle of the first job, which then begins again.
    if (state == RUN && job == 0 && cut != 0 && cycles == cut) begin
      resets = resets + 1;
      cut = resets < 8 ? 20 + drawn[13:8] : 0;
      reset = 1;
      state = RESET;
      clocks = 0;
      rst_n <= 1'b0;
      @OUT@_at = 0;
      @OUT@_beats = 0;
      @OUT@_packets = 0;
      @OUT@_held = 1'b0;
      @OUT@_tready <= 1'b0;
"#;

pub(super) const RESTART_SOURCE: &str = r#"      @IN@_at <= 0;
      @IN@_open = 1'b0;
      @IN@_packets = 0;
      @IN@_beats = 0;
      @IN@_tvalid <= 1'b0;
"#;

pub(super) const END: &str = r#"  end
endmodule
`default_nettype wire
"#;

/// Registers of a script: inputs, and flags that are due after the clock before.
pub(super) const SCRIPT: &str = r#"
  // After the jobs: clocks with broken promises. A word has the inputs of so many clocks, and the flags
  // that must be up, and those that must be down, after each of them. What the unit gives is not compared.
  reg scripted = 1'b0;  // the inputs are those of the script
  integer script_at = 0;
  integer script_clocks = 0;  // of this word
  integer driven_at = 0;
  reg [@FLAGS@-1:0] driven_up = 0;
  reg [@FLAGS@-1:0] driven_down = 0;
  integer due_at = 0;
  reg [@FLAGS@-1:0] due_up = 0;
  reg [@FLAGS@-1:0] due_down = 0;
"#;

/// After the last job.
pub(super) const THEN_SCRIPT: &str = "\
`ifdef POTAMOI_CHECKS
            pass;  // the assertions take kept promises for granted
`else
            state = SCRIPT;
`endif
";

pub(super) const RUN_SCRIPT: &str = r#"
    if (!failed && state == SCRIPT) begin
      if ((stat_errors & due_up) !== due_up || (stat_errors & due_down) !== 0) begin
        $display("FAIL: stat_errors is %b after word %0d of @FILE@: expected %b up, %b down",
          stat_errors, due_at, due_up, due_down);
        fail;
      end
"#;

pub(super) const SCRIPT_TAKEN: &str = r#"      if (!failed && rst_n && @IN@_tvalid && @IN@_tready !== 1'b1) begin
        $display("FAIL: word %0d of @FILE@: @IN@_tready is %b", driven_at, @IN@_tready);
        fail;
      end
"#;

pub(super) const SCRIPT_DRIVES: &str = r#"      due_at = driven_at;
      due_up = driven_up;
      due_down = driven_down;
      driven_at = script_at;
      driven_up = script_at < @COUNT@ ? script_up : 0;
      driven_down = script_at < @COUNT@ ? script_down : 0;
      scripted <= 1'b1;
      rst_n <= script_rst_n;
      cfg_clear <= script_cfg_clear;
"#;

pub(super) const SCRIPT_STEPS: &str = r#"      script_clocks = script_clocks + 1;
      if (script_at == @COUNT@) begin
        if (!failed && script_clocks == 3) pass;
      end else if (script_clocks == script_times) begin
        script_at <= script_at + 1;
        script_clocks = 0;
      end
    end
"#;
