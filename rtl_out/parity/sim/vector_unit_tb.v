// Testbench of vector_unit with golden vectors. Run in the folder of the .hex files:
//   make
//   iverilog -g2005 -o vector_unit_tb vector_unit_tb.v ../vector_unit/*.v && vvp -n vector_unit_tb
// Options: +gaps=P  sources and sink pause in about P % of the clocks, in bursts (default 0)
//          +seed=N  another pattern of pauses (default 1)
//          +dump    write all signals; +dump=FILE into that file
// The last line says PASS or FAIL; the exit status of FAIL is not 0. Without gaps, the cycles of
// every job and all counters are compared too. Jobs:
//   0: 9 vectors: pass
//   1: 9 vectors: relu
//   2: 9 vectors: add
//   3: 9 vectors: multiply
//   4: 9 vectors: square-sum
//   5: 25 vectors: exp
//   6: 25 vectors: one-minus-exp
//   7: 21 vectors: one-minus-exp, add, exp, relu, exp, one-minus-exp, exp, relu, multiply
//   8: 33 vectors: square-sum, multiply, square-sum, multiply, square-sum, multiply, square-sum, multiply, square-sum
//   9: 3 vectors: multiply
//   10: 9 vectors with torn lanes, and some without a lane
//   11: 9 vectors of operations that were not built
//   12: 1 vectors: pass, and a sink that is closed for long
//   13: 3 vectors: pass, relu, add, and a sink that is closed for long
//   14: 12 vectors: pass, relu, add, multiply, square-sum, pass, relu, add, multiply, and a sink that is closed for long
// Then clocks in which promises are broken, from vector_flags.hex, and what flags must say of them.
`timescale 1ns/1ps
`default_nettype none

module vector_unit_tb;
  localparam JOBS = 15;
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

  // job, from vector_jobs.hex: s_axis_vec_from 32, s_axis_vec_end 32, m_axis_vec_from 32,
  // m_axis_vec_end 32, closed 16, cycles 32, stat_vectors 32, stat_busy 32, stat_stall_out 32,
  // stat_errors 3
  reg [274:0] job_words [0:17];
  wire [31:0] job_s_axis_vec_from;
  wire [31:0] job_s_axis_vec_end;
  wire [31:0] job_m_axis_vec_from;
  wire [31:0] job_m_axis_vec_end;
  wire [15:0] job_closed;
  wire [31:0] job_cycles;
  wire [31:0] job_stat_vectors;
  wire [31:0] job_stat_busy;
  wire [31:0] job_stat_stall_out;
  wire [2:0] job_stat_errors;
  assign {
      job_s_axis_vec_from, job_s_axis_vec_end, job_m_axis_vec_from, job_m_axis_vec_end,
      job_closed, job_cycles, job_stat_vectors, job_stat_busy, job_stat_stall_out, job_stat_errors
    } = job_words[job];

  // After the jobs: clocks with broken promises. A word has the inputs of so many clocks, and the flags
  // that must be up, and those that must be down, after each of them. What the unit gives is not compared.
  reg scripted = 1'b0;  // the inputs are those of the script
  integer script_at = 0;
  integer script_clocks = 0;  // of this word
  integer driven_at = 0;
  reg [3-1:0] driven_up = 0;
  reg [3-1:0] driven_down = 0;
  integer due_at = 0;
  reg [3-1:0] due_up = 0;
  reg [3-1:0] due_down = 0;

  // script, from vector_flags.hex: rst_n 1, cfg_clear 1, s_axis_vec_tvalid 1, s_axis_vec_tkeep
  // 192, s_axis_vec_tlast 1, s_axis_vec_tuser 12, times 16, up 3, down 3
  reg [229:0] script_words [0:498];
  wire [0:0] script_rst_n;
  wire [0:0] script_cfg_clear;
  wire [0:0] script_s_axis_vec_tvalid;
  wire [191:0] script_s_axis_vec_tkeep;
  wire [0:0] script_s_axis_vec_tlast;
  wire [11:0] script_s_axis_vec_tuser;
  wire [15:0] script_times;
  wire [2:0] script_up;
  wire [2:0] script_down;
  assign {
      script_rst_n, script_cfg_clear, script_s_axis_vec_tvalid, script_s_axis_vec_tkeep,
      script_s_axis_vec_tlast, script_s_axis_vec_tuser, script_times, script_up, script_down
    } = script_words[script_at < 499 ? script_at : 499 - 1];

  // s_axis_vec, from vector_in.hex: tdata 1536, tkeep 192, tlast 1, tuser 12
  reg [1740:0] s_axis_vec_words [0:188];
  integer s_axis_vec_at = 0;
  integer s_axis_vec_next;
  integer s_axis_vec_rate = 0;
  reg s_axis_vec_open = 1'b0;
  integer s_axis_vec_packets = 0;
  integer s_axis_vec_beats = 0;  // given in all jobs
  reg s_axis_vec_tvalid = 1'b0;
  wire s_axis_vec_tready;
  reg [1741-1:0] s_axis_vec_scripted;
  wire [1741-1:0] s_axis_vec_word = scripted ? s_axis_vec_scripted
    : s_axis_vec_words[s_axis_vec_at < 189 ? s_axis_vec_at : 0];
  // While a source is not valid, its payload is inverted: a unit must not take it.
  wire [1535:0] s_axis_vec_tdata;
  wire [191:0] s_axis_vec_tkeep;
  wire [0:0] s_axis_vec_tlast;
  wire [11:0] s_axis_vec_tuser;
  assign {
      s_axis_vec_tdata, s_axis_vec_tkeep, s_axis_vec_tlast, s_axis_vec_tuser
    } = s_axis_vec_tvalid ? s_axis_vec_word : ~s_axis_vec_word;

  // m_axis_vec, from vector_out.hex: tdata 768, tkeep 96, tlast 1
  reg [864:0] m_axis_vec_words [0:185];
  integer m_axis_vec_at = 0;
  integer m_axis_vec_beats = 0;  // taken in all jobs
  integer m_axis_vec_rate = 0;
  integer m_axis_vec_packets = 0;
  reg m_axis_vec_held = 1'b0;
  reg m_axis_vec_tready = 1'b0;
  wire m_axis_vec_tvalid;
  wire [767:0] m_axis_vec_tdata;
  wire [95:0] m_axis_vec_tkeep;
  wire [0:0] m_axis_vec_tlast;
  wire [767:0] wanted_tdata;
  wire [95:0] wanted_tkeep;
  wire [0:0] wanted_tlast;
  assign {
      wanted_tdata, wanted_tkeep, wanted_tlast
    } = m_axis_vec_words[m_axis_vec_at < 186 ? m_axis_vec_at : 0];
  wire [31:0] stat_vectors;
  wire [31:0] stat_busy;
  wire [31:0] stat_stall_out;
  wire [2:0] stat_errors;

  vector_unit unit (
    .clk(clk),
    .rst_n(rst_n),
    .cfg_clear(cfg_clear),
    .idle(idle),
    .s_axis_vec_tvalid(s_axis_vec_tvalid),
    .s_axis_vec_tready(s_axis_vec_tready),
    .s_axis_vec_tdata(s_axis_vec_tdata),
    .s_axis_vec_tkeep(s_axis_vec_tkeep),
    .s_axis_vec_tlast(s_axis_vec_tlast),
    .s_axis_vec_tuser(s_axis_vec_tuser),
    .m_axis_vec_tvalid(m_axis_vec_tvalid),
    .m_axis_vec_tready(m_axis_vec_tready),
    .m_axis_vec_tdata(m_axis_vec_tdata),
    .m_axis_vec_tkeep(m_axis_vec_tkeep),
    .m_axis_vec_tlast(m_axis_vec_tlast),
    .stat_vectors(stat_vectors),
    .stat_busy(stat_busy),
    .stat_stall_out(stat_stall_out),
    .stat_errors(stat_errors)
  );

  // Options, and memory files that are missing or have too few words.
  integer file;
  reg [8*256-1:0] dump;
  initial begin
    if (!$value$plusargs("gaps=%d", gaps)) gaps = 0;
    if (!$value$plusargs("seed=%d", seed)) seed = 1;
    if (gaps < 0 || gaps > 95) begin
      $display("FAIL: +gaps=%0d: expected 0 to 95", gaps);
      fail;
    end
    drawn = after(32'h9e3779b9 ^ (seed << 4)) | 32'd1;
    if (gaps > 0) cut = 20 + drawn[13:8];
    if ($value$plusargs("dump=%s", dump)) begin
      $dumpfile(dump);
      $dumpvars;
    end else if ($test$plusargs("dump")) begin
      $dumpvars;
    end
    file = $fopen("vector_jobs.hex", "r");
    if (file == 0) begin
      if (!failed) $display("FAIL: vector_jobs.hex is missing: run in the folder of the .hex files");
      fail;
    end else begin
      $fclose(file);
      $readmemh("vector_jobs.hex", job_words);
      if (^job_words[17] === 1'bx) begin
        if (!failed) $display("FAIL: vector_jobs.hex has fewer words than this bench reads");
        fail;
      end
    end
    file = $fopen("vector_in.hex", "r");
    if (file == 0) begin
      if (!failed) $display("FAIL: vector_in.hex is missing: run in the folder of the .hex files");
      fail;
    end else begin
      $fclose(file);
      $readmemh("vector_in.hex", s_axis_vec_words);
      if (^s_axis_vec_words[188] === 1'bx) begin
        if (!failed) $display("FAIL: vector_in.hex has fewer words than this bench reads");
        fail;
      end
    end
    file = $fopen("vector_out.hex", "r");
    if (file == 0) begin
      if (!failed) $display("FAIL: vector_out.hex is missing: run in the folder of the .hex files");
      fail;
    end else begin
      $fclose(file);
      $readmemh("vector_out.hex", m_axis_vec_words);
      if (^m_axis_vec_words[185] === 1'bx) begin
        if (!failed) $display("FAIL: vector_out.hex has fewer words than this bench reads");
        fail;
      end
    end
    file = $fopen("vector_flags.hex", "r");
    if (file == 0) begin
      if (!failed) $display("FAIL: vector_flags.hex is missing: run in the folder of the .hex files");
      fail;
    end else begin
      $fclose(file);
      $readmemh("vector_flags.hex", script_words);
      if (^script_words[498] === 1'bx) begin
        if (!failed) $display("FAIL: vector_flags.hex has fewer words than this bench reads");
        fail;
      end
    end
  end

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
      $display("PASS: vector_unit, %0d beats in %0d jobs, +gaps=%0d +seed=%0d",
        m_axis_vec_beats, JOBS, gaps, seed);
      failed = 1'b1;
      state = DONE;
      $finish(0);
    end
  endtask

  reg [767:0] found;
  reg [767:0] wanted;
  integer low;
  integer lowest = 0;  // a variable: a loop from a constant fails in Verilator 5.006
  task differs(input [8*8-1:0] field);
    begin
      low = lowest;
      while (low < 767 - 31 && found[low +: 32] === wanted[low +: 32]) low = low + 32;
      if (found[low +: 16] === wanted[low +: 16]) low = low + 16;
      $display("FAIL: beat %0d: m_axis_vec_%0s[%0d +: 16] is %h, expected %h",
        m_axis_vec_at, field, low, found[low +: 16], wanted[low +: 16]);
      fail;
    end
  endtask

  task compare;
    begin
      if (!failed && m_axis_vec_tdata !== wanted_tdata) begin
        found = m_axis_vec_tdata;
        wanted = wanted_tdata;
        differs("tdata");
      end
      if (!failed && m_axis_vec_tkeep !== wanted_tkeep) begin
        found = m_axis_vec_tkeep;
        wanted = wanted_tkeep;
        differs("tkeep");
      end
      if (!failed && m_axis_vec_tlast !== wanted_tlast) begin
        found = m_axis_vec_tlast;
        wanted = wanted_tlast;
        differs("tlast");
      end
    end
  endtask

  wire idle;
  task check_idle;
    begin
      if (!failed && state != RESET && state != SCRIPT && idle !== 1'b0
          && (idle !== 1'b1 || m_axis_vec_tvalid || s_axis_vec_beats != m_axis_vec_beats)) begin
        $display("FAIL: idle is %b while there is work inside", idle);
        fail;
      end
    end
  endtask

  // After a job: counters, flags, cycles, and beats that were not taken.
  task check_job;
    begin
      if (!failed && gaps == 0 && cycles != job_cycles) begin
        $display("FAIL: %0d cycles, expected %0d", cycles, job_cycles);
        fail;
      end
      if (!failed && stat_vectors !== job_stat_vectors) begin
        $display("FAIL: stat_vectors is %0d, expected %0d", stat_vectors, job_stat_vectors);
        fail;
      end
      if (!failed && stat_busy !== job_stat_busy) begin
        $display("FAIL: stat_busy is %0d, expected %0d", stat_busy, job_stat_busy);
        fail;
      end
      if (!failed && gaps == 0 && stat_stall_out !== job_stat_stall_out) begin
        $display("FAIL: stat_stall_out is %0d, expected %0d", stat_stall_out, job_stat_stall_out);
        fail;
      end
      if (!failed && stat_errors !== job_stat_errors) begin
        $display("FAIL: stat_errors is %0d, expected %0d", stat_errors, job_stat_errors);
        fail;
      end
      if (!failed && s_axis_vec_at != job_s_axis_vec_end) begin
        $display("FAIL: %0d beats of s_axis_vec were not taken", job_s_axis_vec_end - s_axis_vec_at);
        fail;
      end
    end
  endtask

  always @(posedge clk) if (!failed) begin
    clocks = clocks + 1;
    quiet = quiet + 1;
    if (state == RUN) cycles = cycles + 1;
    check_idle;
    if (!failed && state != RESET && state != SCRIPT) begin
      if (m_axis_vec_tvalid !== 1'b0 && m_axis_vec_tvalid !== 1'b1) begin
        $display("FAIL: m_axis_vec_tvalid is %b", m_axis_vec_tvalid);
        fail;
      end else if (m_axis_vec_held && !m_axis_vec_tvalid) begin
        $display("FAIL: m_axis_vec_tvalid fell before beat %0d was taken", m_axis_vec_at);
        fail;
      end else if (m_axis_vec_tvalid && state != RUN) begin
        $display("FAIL: a surplus beat of m_axis_vec after beat %0d", m_axis_vec_at);
        fail;
      end else if (m_axis_vec_tvalid) begin
        compare;
      end
      m_axis_vec_held = m_axis_vec_tvalid && !m_axis_vec_tready;
      if (m_axis_vec_tvalid && m_axis_vec_tready) begin
        m_axis_vec_at = m_axis_vec_at + 1;
        m_axis_vec_beats = m_axis_vec_beats + 1;
        if (m_axis_vec_tlast === 1'b1) m_axis_vec_packets = m_axis_vec_packets + 1;
        quiet = 0;
      end
    end
    case (state)
      RESET: begin
        // All inputs but reset may have any value.
        if (clocks > 2 && m_axis_vec_tvalid !== 1'b0) begin
          $display("FAIL: m_axis_vec_tvalid is %b in reset", m_axis_vec_tvalid);
          fail;
        end
        if (!failed && clocks > 1 && s_axis_vec_tready !== 1'b0) begin
          $display("FAIL: s_axis_vec_tready is %b in reset", s_axis_vec_tready);
          fail;
        end
        if (!failed && clocks == reset) begin
          rst_n <= 1'b1;
          state = BEGIN;
          clocks = 0;
          is_fresh = 1'b1;
        end
      end
      BEGIN: begin
        if (clocks == 1) begin
          if (!failed && is_fresh && stat_vectors !== 0) begin
            $display("FAIL: stat_vectors is %0d after reset", stat_vectors);
            fail;
          end
          if (!failed && is_fresh && stat_busy !== 0) begin
            $display("FAIL: stat_busy is %0d after reset", stat_busy);
            fail;
          end
          if (!failed && is_fresh && stat_stall_out !== 0) begin
            $display("FAIL: stat_stall_out is %0d after reset", stat_stall_out);
            fail;
          end
          if (!failed && is_fresh && stat_errors !== 0) begin
            $display("FAIL: stat_errors is %0d after reset", stat_errors);
            fail;
          end
          is_fresh = 1'b0;
          m_axis_vec_at = job_m_axis_vec_from;
          cfg_clear <= 1'b1;
        end else if (clocks == 2) begin
          cfg_clear <= 1'b0;
        end else begin
          if (!failed && stat_vectors !== 0) begin
            $display("FAIL: stat_vectors is %0d after cfg_clear", stat_vectors);
            fail;
          end
          if (!failed && stat_busy !== 0) begin
            $display("FAIL: stat_busy is %0d after cfg_clear", stat_busy);
            fail;
          end
          if (!failed && stat_stall_out !== 0) begin
            $display("FAIL: stat_stall_out is %0d after cfg_clear", stat_stall_out);
            fail;
          end
          if (!failed && stat_errors !== 0) begin
            $display("FAIL: stat_errors is %0d after cfg_clear", stat_errors);
            fail;
          end
          if (!failed) state = RUN;
          clocks = 0;
          cycles = 0;
          quiet = 0;
        end
      end
      RUN: begin
        if (m_axis_vec_at == job_m_axis_vec_end) begin
          state = DRAIN;
          clocks = 0;
        end else if (quiet > 5000) begin
          $display("FAIL: nothing moved for %0d clocks before beat %0d", quiet, m_axis_vec_at);
          fail;
        end
      end
      DRAIN: begin
        if (clocks == 40) begin
          check_job;
          if (!failed && idle !== 1'b1) begin
            $display("FAIL: idle is %b after the job", idle);
            fail;
          end
          if (!failed && job + 1 == JOBS) begin
`ifdef POTAMOI_CHECKS
            pass;  // the assertions take kept promises for granted
`else
            state = SCRIPT;
`endif
          end else if (!failed) begin
            job = job + 1;
            state = BEGIN;
            clocks = 0;
          end
        end
      end
      default: ;
    endcase

    closed = state == RUN && cycles < (gaps == 0 ? job_closed : job % 2 == 1 ? CLOSED : 0);
    moved = rst_n && s_axis_vec_tvalid && s_axis_vec_tready === 1'b1;
    if (moved) begin
      quiet = 0;
      s_axis_vec_beats = s_axis_vec_beats + 1;
      s_axis_vec_open = !s_axis_vec_tlast;
      if (s_axis_vec_tlast) s_axis_vec_packets = s_axis_vec_packets + 1;
    end
    drawn = after(drawn);
    if (clocks % 32 == 1) s_axis_vec_rate = rate(drawn[9:8]);
    drawn = after(drawn);
    willing = closed || drawn[30:8] % 100 >= s_axis_vec_rate;
    s_axis_vec_next = state == BEGIN && clocks == 1 ? job_s_axis_vec_from : s_axis_vec_at + (moved ? 1 : 0);
    s_axis_vec_at <= s_axis_vec_next;
    s_axis_vec_tvalid <= state == RUN && s_axis_vec_next < job_s_axis_vec_end
      && (willing || (s_axis_vec_tvalid && !moved));
    drawn = after(drawn);
    if (clocks % 32 == 1) m_axis_vec_rate = rate(drawn[9:8]);
    drawn = after(drawn);
    willing = !closed && drawn[30:8] % 100 >= m_axis_vec_rate;
    m_axis_vec_tready <= state == DRAIN || state == SCRIPT || (state == RUN && willing);

    // Resets of one clock in the middle of the first job, which then begins again.
    if (state == RUN && job == 0 && cut != 0 && cycles == cut) begin
      resets = resets + 1;
      cut = resets < 8 ? 20 + drawn[13:8] : 0;
      reset = 1;
      state = RESET;
      clocks = 0;
      rst_n <= 1'b0;
      m_axis_vec_at = 0;
      m_axis_vec_beats = 0;
      m_axis_vec_packets = 0;
      m_axis_vec_held = 1'b0;
      m_axis_vec_tready <= 1'b0;
      s_axis_vec_at <= 0;
      s_axis_vec_open = 1'b0;
      s_axis_vec_packets = 0;
      s_axis_vec_beats = 0;
      s_axis_vec_tvalid <= 1'b0;
    end

    if (!failed && state == SCRIPT) begin
      if ((stat_errors & due_up) !== due_up || (stat_errors & due_down) !== 0) begin
        $display("FAIL: stat_errors is %b after word %0d of vector_flags.hex: expected %b up, %b down",
          stat_errors, due_at, due_up, due_down);
        fail;
      end
      if (!failed && rst_n && s_axis_vec_tvalid && s_axis_vec_tready !== 1'b1) begin
        $display("FAIL: word %0d of vector_flags.hex: s_axis_vec_tready is %b", driven_at, s_axis_vec_tready);
        fail;
      end
      due_at = driven_at;
      due_up = driven_up;
      due_down = driven_down;
      driven_at = script_at;
      driven_up = script_at < 499 ? script_up : 0;
      driven_down = script_at < 499 ? script_down : 0;
      scripted <= 1'b1;
      rst_n <= script_rst_n;
      cfg_clear <= script_cfg_clear;
      s_axis_vec_tvalid <= script_s_axis_vec_tvalid;
      s_axis_vec_scripted <= {
        1536'd0, script_s_axis_vec_tkeep, script_s_axis_vec_tlast, script_s_axis_vec_tuser
      };
      script_clocks = script_clocks + 1;
      if (script_at == 499) begin
        if (!failed && script_clocks == 3) pass;
      end else if (script_clocks == script_times) begin
        script_at <= script_at + 1;
        script_clocks = 0;
      end
    end
  end
endmodule
`default_nettype wire
