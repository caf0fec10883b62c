//! Parts of the bench of the SoC top. `@NAME@` stands for what differs between streams.

pub(super) const BEGIN: &str = r#"// Options: +gaps=P  sources, sinks and the bus pause in about P % of the clocks (default 0)
//          +seed=N  another pattern of pauses (default 1)
//          +dump    write all signals; +dump=FILE into that file
// The last line says PASS or FAIL; the exit status of FAIL is not 0. It holds every register to the
// table, then runs the jobs of both units at once, by interrupts. Sources offer the beats of all jobs
// without a stop, so that the top has to keep the jobs apart. With gaps, a reset cuts the first jobs off,
// which then begin again; without, all counters are compared. Last come beats that raise error flags.
`timescale 1ns/1ps
`default_nettype none

module potamoi_npu_ext_tb;
  localparam [1:0] OKAY = 2'd0;
  localparam [1:0] SLVERR = 2'd2;
  localparam PATIENCE = 5000;  // clocks without a beat
  localparam SHOWN = 200;      // clocks after which a beat has raised its flag

  reg clk = 1'b0;
  always #5 clk = ~clk;
  reg rst_n = 1'b0;

  integer gaps;
  integer seed;
  integer round = 0;
  integer gu_first = 0;  // job whose beats are offered after a reset
  integer vu_first = 0;
  integer quiet = 0;   // clocks since a beat moved
  integer cut = 0;     // clocks after which a reset cuts the first jobs off
  reg failed = 1'b0;
  reg [31:0] mode;
  reg [31:0] many = 32'd0;  // packets in place of those of a job

  // Pauses are drawn from xorshift generators, so that all simulators draw the same.
  reg [31:0] drawn = 32'd1;      // of the streams
  reg [31:0] bus_drawn = 32'd1;  // of the bus
  function [31:0] after(input [31:0] x);
    begin
      after = x ^ (x << 13);
      after = after ^ (after >> 17);
      after = after ^ (after << 5);
    end
  endfunction

  reg [11:0] s_axil_awaddr = 12'd0;
  reg [2:0] s_axil_awprot = 3'd0;
  reg s_axil_awvalid = 1'b0;
  wire s_axil_awready;
  reg [31:0] s_axil_wdata = 32'd0;
  reg [3:0] s_axil_wstrb = 4'd0;
  reg s_axil_wvalid = 1'b0;
  wire s_axil_wready;
  wire [1:0] s_axil_bresp;
  wire s_axil_bvalid;
  reg s_axil_bready = 1'b0;
  reg [11:0] s_axil_araddr = 12'd0;
  reg [2:0] s_axil_arprot = 3'd0;
  reg s_axil_arvalid = 1'b0;
  wire s_axil_arready;
  wire [31:0] s_axil_rdata;
  wire [1:0] s_axil_rresp;
  wire s_axil_rvalid;
  reg s_axil_rready = 1'b0;
  wire irq;

"#;

pub(super) const SOURCE: &str = r#"  integer @NAME@_job = 0;  // whose beats are offered
  integer @NAME@_at = 0;
  integer @NAME@_next;
  reg @NAME@_moved;
  reg @NAME@_tvalid = 1'b0;
  wire @NAME@_tready;
  wire [@WIDTH@-1:0] @NAME@_word = @NAME@_words[@NAME@_at < @COUNT@ ? @NAME@_at : 0];
  // While a source is not valid, its payload is inverted: the top must not take it.
"#;

pub(super) const SINK: &str = r#"  integer @NAME@_at = 0;
  integer @NAME@_ends = 0;  // of packets that were taken
  reg @NAME@_held = 1'b0;
  reg @NAME@_tready = 1'b0;
  wire @NAME@_tvalid;
  wire [@WIDTH@-1:0] @NAME@_found;
"#;

pub(super) const STREAMS: &str = r#"
  always @(posedge clk) if (!failed) begin
"#;

/// `@JOBS@` is a number of jobs, `@FIRST@` the first one after a reset; `@FROM@` and `@END@` are bits of
/// the words of jobs.
pub(super) const OFFER: &str = r#"    if (!rst_n) begin
      if (@NAME@_tready !== 1'b0 && $time > 0) begin
        $display("FAIL: @NAME@_tready is %b in reset", @NAME@_tready);
        fail;
      end
      @NAME@_job = @FIRST@;
      @NAME@_at <= @WORDS@[@FIRST@][@FROM@];
      @NAME@_tvalid <= 1'b0;
    end else begin
      @NAME@_moved = @NAME@_tvalid && @NAME@_tready === 1'b1;
      @NAME@_next = @NAME@_at;
      if (@NAME@_moved) begin
        @NAME@_next = @NAME@_at + 1;
        quiet = 0;
      end
      while (@NAME@_job + 1 < @JOBS@ && @NAME@_next == @WORDS@[@NAME@_job][@END@]) begin
        @NAME@_job = @NAME@_job + 1;
        @NAME@_next = @WORDS@[@NAME@_job][@FROM@];
      end
      drawn = after(drawn);
      @NAME@_at <= @NAME@_next;
      @NAME@_tvalid <= @NAME@_next != @WORDS@[@NAME@_job][@END@]
        && (drawn[30:8] % 100 >= gaps || (@NAME@_tvalid && !@NAME@_moved));
    end
"#;

pub(super) const TAKE: &str = r#"    drawn = after(drawn);
    if (!rst_n) begin
      @NAME@_at = @FROM@;
      @NAME@_ends = 0;
      @NAME@_held = 1'b0;
      @NAME@_tready <= 1'b0;
    end else begin
      if (@NAME@_tvalid !== 1'b0 && @NAME@_tvalid !== 1'b1) begin
        $display("FAIL: @NAME@_tvalid is %b", @NAME@_tvalid);
        fail;
      end else if (@NAME@_held && !@NAME@_tvalid) begin
        $display("FAIL: @NAME@_tvalid fell before beat %0d was taken", @NAME@_at);
        fail;
      end else if (@NAME@_tvalid && many == 32'd0 && @NAME@_at == @END@) begin
        $display("FAIL: a surplus beat of @NAME@");
        fail;
      // A job of many packets takes beats of the next one, whose settings are others.
      end else if (@NAME@_tvalid && @NAME@_at < @END@
          && @NAME@_found !== @NAME@_words[@NAME@_at]) begin
        $display("FAIL: beat %0d of @NAME@ is %h, expected %h", @NAME@_at, @NAME@_found,
          @NAME@_words[@NAME@_at]);
        fail;
      end
      @NAME@_held = @NAME@_tvalid && !@NAME@_tready;
      if (@NAME@_tvalid && @NAME@_tready) begin
        @NAME@_at = @NAME@_at + 1;
        if (@NAME@_tlast === 1'b1) @NAME@_ends = @NAME@_ends + 1;
        quiet = 0;
      end
      @NAME@_tready <= drawn[30:8] % 100 >= gaps;
    end
"#;

pub(super) const MAIN: &str = r#"
  task reset;
    begin
      rst_n = 1'b0;
      repeat (4) @(negedge clk);
      if (!failed && {s_axil_awready, s_axil_wready, s_axil_arready, s_axil_bvalid, s_axil_rvalid, irq} !== 6'd0)
      begin
        $display("FAIL: the bus or irq is not low in reset");
        fail;
      end
      rst_n = 1'b1;
      @(negedge clk);
    end
  endtask

  // Jobs of 2^k and 2^k - 1 packets stay open, and let beats of all streams in.
  integer taken;  // packets, before the register is read
  task large_counts;
    begin
      many = 32'd1 << 31;
      while (!failed && many >= 32'd256) begin
        gu_begin;
        vu_begin;
        read(STATUS, OKAY);
        if (!failed && (~word & (STATUS_GU_RUNNING | STATUS_VU_RUNNING)) != 0) begin
          $display("FAIL: a job of %0d packets is not begun", many);
          fail;
        end
        quiet = 0;
        while (!failed && (@WAITING@)) begin
          @(negedge clk);
          quiet = quiet + 1;
          if (quiet > PATIENCE) begin
            $display("FAIL: no beat for %0d clocks in a job of %0d packets", quiet, many);
            fail;
          end
        end
        taken = m_axis_feat_ends;
        read(GU_LEFT, OKAY);
        are_left(GU_LEFT, taken, m_axis_feat_ends);
        taken = m_axis_vec_ends;
        read(VU_LEFT, OKAY);
        are_left(VU_LEFT, taken, m_axis_vec_ends);
        reset;
        // 2^k, 2^k - 1, 2^(k - 1), and so on.
        many = (many & (many - 1)) == 32'd0 ? many | (many - 1) : (many >> 1) & ~(many >> 2);
      end
      many = 32'd0;
    end
  endtask

  // Packets that are left, of those of the job: those that were taken before the read and after.
  task are_left(input [11:0] address, input integer least, input integer most);
    if (!failed && (many - word < least || many - word > most)) begin
      $display("FAIL: register %h is %h in a job of %h packets, of which %0d to %0d are taken",
        address, word, many, least, most);
      fail;
    end
  endtask

  reg gu_runs;
  reg vu_runs;
  reg [31:0] shown;  // before the counters are cleared
  reg [31:0] events;  // of the jobs that run
  reg gu_worked = 1'b0;  // STATUS has shown that it is not idle
  reg vu_worked = 1'b0;
  task run_round;
    begin
      gu_runs = round < GU_JOBS;
      vu_runs = round < VU_JOBS;
      gu_job = gu_runs ? round : GU_JOBS - 1;
      vu_job = vu_runs ? round : VU_JOBS - 1;
      events = 32'd0;
      read(GU_ENTRIES, OKAY);
      shown = word;
      write(CONTROL, CONTROL_CLEAR, 4'hf, OKAY);
      // Counters are shown as of the snapshot.
      check(GU_ENTRIES, shown);
      write(IRQ_ENABLE, IRQ_STATUS_GU_DONE | IRQ_STATUS_VU_DONE, 4'hf, OKAY);
      if (gu_runs) gu_begin;
      if (vu_runs) vu_begin;
      read(STATUS, OKAY);
      if ((word & STATUS_GU_IDLE) == 0) gu_worked = 1'b1;
      if ((word & STATUS_VU_IDLE) == 0) vu_worked = 1'b1;
      if (cut != 0) begin
        repeat (cut) @(negedge clk);
        cut = 0;
        reset;
        check_registers;
      end else begin
        // A job of no packets is refused while another runs.
        write(GU_PACKETS, 32'd0, 4'hf, OKAY);
        write(CONTROL, CONTROL_GU_START, 4'hf, OKAY);
        read(IRQ_STATUS, OKAY);
        if (!failed && (word & IRQ_STATUS_GU_REFUSED) == 0) begin
          $display("FAIL: a start for no packets was not refused");
          fail;
        end
        write(IRQ_STATUS, IRQ_STATUS_GU_REFUSED, 4'h1, OKAY);
        while (!failed && (gu_runs || vu_runs)) wait_for_done;
        finish_round;
      end
    end
  endtask

  task wait_for_done;
    begin
      quiet = 0;
      while (!failed && irq !== 1'b1) begin
        @(negedge clk);
        quiet = quiet + 1;
        if (quiet > PATIENCE) begin
          $display("FAIL: no interrupt, and no beat for %0d clocks", quiet);
          fail;
        end
      end
      read(IRQ_STATUS, OKAY);
      write(IRQ_STATUS, word, 4'hf, OKAY);
      events = events | word;
      if (!failed && (word & (IRQ_STATUS_GU_DONE | IRQ_STATUS_VU_DONE)) == 0) begin
        $display("FAIL: an interrupt without an event");
        fail;
      end
      if ((word & IRQ_STATUS_GU_DONE) != 0) gu_runs = 1'b0;
      if ((word & IRQ_STATUS_VU_DONE) != 0) vu_runs = 1'b0;
      repeat (2) @(negedge clk);
    end
  endtask

  // An event interrupts if it is enabled, and no other enable makes it.
  task interrupts(input [31:0] event_bit);
    begin
      write(IRQ_ENABLE, event_bit, 4'hf, OKAY);
      repeat (2) @(negedge clk);
      if (!failed && irq !== 1'b1) begin
        $display("FAIL: no interrupt of event %b", event_bit);
        fail;
      end
      read(IRQ_STATUS, OKAY);
      write(IRQ_ENABLE, ~word, 4'hf, OKAY);
      repeat (2) @(negedge clk);
      if (!failed && irq !== 1'b0) begin
        $display("FAIL: an interrupt of events %b, none of which is enabled", word);
        fail;
      end
    end
  endtask

  task finish_round;
    begin
      events = events & ~(IRQ_STATUS_GU_DONE | IRQ_STATUS_VU_DONE);
      if (round < GU_JOBS && gu_job_stat_errors != 0) events = events ^ IRQ_STATUS_GU_ERROR;
      if (round < VU_JOBS && vu_job_stat_errors != 0) events = events ^ IRQ_STATUS_VU_ERROR;
      if (!failed && events != 32'd0) begin
        $display("FAIL: events %b are missing or there without a flag", events);
        fail;
      end
      check(STATUS, STATUS_GU_IDLE | STATUS_VU_IDLE);
      check(GU_LEFT, 32'd0);
      check(VU_LEFT, 32'd0);
      write(CONTROL, CONTROL_SNAPSHOT, 4'hf, OKAY);
      if (round < GU_JOBS) gu_check;
      if (round < VU_JOBS) vu_check;
      // Nor is a job of no packets begun while nothing runs.
      write(VU_PACKETS, 32'd0, 4'hf, OKAY);
      write(CONTROL, CONTROL_GU_START | CONTROL_VU_START, 4'hf, OKAY);
      check(STATUS, STATUS_GU_IDLE | STATUS_VU_IDLE);
      check(IRQ_STATUS, IRQ_STATUS_GU_REFUSED | IRQ_STATUS_VU_REFUSED);
      interrupts(IRQ_STATUS_GU_REFUSED);
      interrupts(IRQ_STATUS_VU_REFUSED);
      write(IRQ_STATUS, 32'hffffffff, 4'hf, OKAY);
      round = round + 1;
    end
  endtask
"#;

pub(super) const RUN: &str = r#"
    @(negedge clk);
    reset;
    check_registers;
    read_elsewhere;
    large_counts;
    while (!failed && (round < GU_JOBS || round < VU_JOBS)) run_round;
`ifndef POTAMOI_CHECKS
    break_promises;  // the assertions take kept promises for granted
`endif
    repeat (40) @(negedge clk);
    if (!failed && !(gu_worked && vu_worked)) begin
      $display("FAIL: STATUS never showed that a unit is not idle");
      fail;
    end
    if (!failed) begin
      $display("PASS: potamoi_npu_ext, %0d gathering and %0d vector jobs, +gaps=%0d +seed=%0d",
        GU_JOBS, VU_JOBS, gaps, seed);
      failed = 1'b1;
      $finish(0);
    end
  end
endmodule
`default_nettype wire
"#;

/// A task for the beats of a unit that raise a flag, in a job that stays open.
pub(super) const BREAK: &str = r#"
  // The beats of a job that break a promise raise flags, which interrupt until they are cleared.
  task @SHORT@_break(input integer number, input [31:0] up, input [31:0] down);
    begin
      @SHORT@_first = number;
      @SHORT@_job = number;
      reset;
      many = 32'd1 << 31;
      @SHORT@_begin;
      quiet = 0;
      while (!failed && (@WAITING@)) begin
        @(negedge clk);
        quiet = quiet + 1;
        if (quiet > PATIENCE) begin
          $display("FAIL: no beat for %0d clocks, and job %0d is not taken", quiet, number);
          fail;
        end
      end
      repeat (SHOWN) @(negedge clk);
      read(@UPPER@_ERRORS, OKAY);
      if (!failed && ((word & up) != up || (word & down) != 0)) begin
        $display("FAIL: register %h is %b after job %0d: expected %b up, %b down",
          @UPPER@_ERRORS, word, number, up, down);
        fail;
      end
      read(IRQ_STATUS, OKAY);
      if (!failed && (word & IRQ_STATUS_@UPPER@_ERROR) == 0) begin
        $display("FAIL: no event of the flags %b", up);
        fail;
      end
      interrupts(IRQ_STATUS_@UPPER@_ERROR);
      write(CONTROL, CONTROL_CLEAR, 4'hf, OKAY);
      read(@UPPER@_ERRORS, OKAY);
      if (!failed && (word & up) != 0) begin
        $display("FAIL: flags %b are up after they were cleared", word);
        fail;
      end
      many = 32'd0;
      @SHORT@_first = 0;
    end
  endtask
"#;

/// Reads of addresses without a register, up to the statements that name them.
pub(super) const HOLES: &str = r#"
  // Addresses from one to another have no register.
  reg [11:0] hole;
  task read_hole(input [11:0] from, input [11:0] to);
    begin
      hole = from;
      while (!failed && hole != to) begin
        read(hole, SLVERR);
        hole = hole + 12'd4;
      end
      read(to, SLVERR);
    end
  endtask

  task read_elsewhere;
    begin
"#;
