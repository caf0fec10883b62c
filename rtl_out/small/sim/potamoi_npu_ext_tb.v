// Testbench of potamoi_npu_ext with golden vectors. Run in the folder of the .hex files:
//   make
//   iverilog -g2005 -o potamoi_npu_ext_tb potamoi_npu_ext_tb.v \
//     ../potamoi_npu_ext/*.v ../gathering_unit/*.v ../vector_unit/*.v && vvp -n potamoi_npu_ext_tb
// Options: +gaps=P  sources, sinks and the bus pause in about P % of the clocks (default 0)
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

  localparam [11:0] ID = 12'h000;
  localparam [11:0] VERSION = 12'h004;
  localparam [11:0] CONFIG_LOW = 12'h008;
  localparam [11:0] CONFIG_HIGH = 12'h00c;
  localparam [11:0] GU_PARAMS = 12'h010;
  localparam [11:0] GU_LIMITS = 12'h014;
  localparam [11:0] GU_STREAMS = 12'h018;
  localparam [11:0] VU_PARAMS = 12'h01c;
  localparam [11:0] CONTROL = 12'h020;
  localparam [11:0] STATUS = 12'h024;
  localparam [11:0] IRQ_STATUS = 12'h028;
  localparam [11:0] IRQ_ENABLE = 12'h02c;
  localparam [11:0] GU_MODE = 12'h040;
  localparam [11:0] GU_PACKETS = 12'h044;
  localparam [11:0] GU_LEFT = 12'h048;
  localparam [11:0] GU_ERRORS = 12'h04c;
  localparam [11:0] VU_PACKETS = 12'h050;
  localparam [11:0] VU_LEFT = 12'h054;
  localparam [11:0] VU_ERRORS = 12'h058;
  localparam [11:0] GU_BUSY = 12'h100;
  localparam [11:0] GU_STALL_FIFO = 12'h108;
  localparam [11:0] GU_STALL_MFT = 12'h110;
  localparam [11:0] GU_STALL_RIT = 12'h118;
  localparam [11:0] GU_ENTRIES = 12'h128;
  localparam [11:0] VU_VECTORS = 12'h180;
  localparam [11:0] VU_BUSY = 12'h188;
  localparam [11:0] VU_STALL_OUT = 12'h190;
  localparam [31:0] CONTROL_GU_START = 32'h1;
  localparam [31:0] CONTROL_VU_START = 32'h2;
  localparam [31:0] CONTROL_CLEAR = 32'h4;
  localparam [31:0] CONTROL_SNAPSHOT = 32'h8;
  localparam [31:0] STATUS_GU_RUNNING = 32'h1;
  localparam [31:0] STATUS_VU_RUNNING = 32'h2;
  localparam [31:0] STATUS_GU_IDLE = 32'h4;
  localparam [31:0] STATUS_VU_IDLE = 32'h8;
  localparam [31:0] IRQ_STATUS_GU_DONE = 32'h1;
  localparam [31:0] IRQ_STATUS_VU_DONE = 32'h2;
  localparam [31:0] IRQ_STATUS_GU_ERROR = 32'h4;
  localparam [31:0] IRQ_STATUS_VU_ERROR = 32'h8;
  localparam [31:0] IRQ_STATUS_GU_REFUSED = 32'h10;
  localparam [31:0] IRQ_STATUS_VU_REFUSED = 32'h20;

  integer gu_job = 0;
  localparam GU_JOBS = 69;

  // gu_job, from gather_jobs.hex: cfg_vertices 2, cfg_segments 7, s_axis_rit_from 32,
  // s_axis_rit_end 32, s_axis_mft_from 32, s_axis_mft_end 32, m_axis_feat_from 32, m_axis_feat_end
  // 32, closed 16, cycles 32, stat_busy 32, stat_stall_fifo 32, stat_stall_mft 32, stat_stall_rit
  // 32, stat_entries 32, stat_errors 9
  reg [417:0] gu_job_words [0:73];
  wire [1:0] gu_job_cfg_vertices;
  wire [6:0] gu_job_cfg_segments;
  wire [31:0] gu_job_s_axis_rit_from;
  wire [31:0] gu_job_s_axis_rit_end;
  wire [31:0] gu_job_s_axis_mft_from;
  wire [31:0] gu_job_s_axis_mft_end;
  wire [31:0] gu_job_m_axis_feat_from;
  wire [31:0] gu_job_m_axis_feat_end;
  wire [15:0] gu_job_closed;
  wire [31:0] gu_job_cycles;
  wire [31:0] gu_job_stat_busy;
  wire [31:0] gu_job_stat_stall_fifo;
  wire [31:0] gu_job_stat_stall_mft;
  wire [31:0] gu_job_stat_stall_rit;
  wire [31:0] gu_job_stat_entries;
  wire [8:0] gu_job_stat_errors;
  assign {
      gu_job_cfg_vertices, gu_job_cfg_segments, gu_job_s_axis_rit_from, gu_job_s_axis_rit_end,
      gu_job_s_axis_mft_from, gu_job_s_axis_mft_end, gu_job_m_axis_feat_from,
      gu_job_m_axis_feat_end, gu_job_closed, gu_job_cycles, gu_job_stat_busy,
      gu_job_stat_stall_fifo, gu_job_stat_stall_mft, gu_job_stat_stall_rit, gu_job_stat_entries,
      gu_job_stat_errors
    } = gu_job_words[gu_job];

  // s_axis_rit, from gather_rit.hex: tdata 64, tkeep 8, tlast 1, tuser 1
  reg [73:0] s_axis_rit_words [0:5795];
  integer s_axis_rit_job = 0;  // whose beats are offered
  integer s_axis_rit_at = 0;
  integer s_axis_rit_next;
  reg s_axis_rit_moved;
  reg s_axis_rit_tvalid = 1'b0;
  wire s_axis_rit_tready;
  wire [74-1:0] s_axis_rit_word = s_axis_rit_words[s_axis_rit_at < 5796 ? s_axis_rit_at : 0];
  // While a source is not valid, its payload is inverted: the top must not take it.
  wire [63:0] s_axis_rit_tdata;
  wire [7:0] s_axis_rit_tkeep;
  wire [0:0] s_axis_rit_tlast;
  wire [0:0] s_axis_rit_tuser;
  assign {
      s_axis_rit_tdata, s_axis_rit_tkeep, s_axis_rit_tlast, s_axis_rit_tuser
    } = s_axis_rit_tvalid ? s_axis_rit_word : ~s_axis_rit_word;

  // s_axis_mft, from gather_mft.hex: tdata 128, tlast 1
  reg [128:0] s_axis_mft_words [0:1774];
  integer s_axis_mft_job = 0;  // whose beats are offered
  integer s_axis_mft_at = 0;
  integer s_axis_mft_next;
  reg s_axis_mft_moved;
  reg s_axis_mft_tvalid = 1'b0;
  wire s_axis_mft_tready;
  wire [129-1:0] s_axis_mft_word = s_axis_mft_words[s_axis_mft_at < 1775 ? s_axis_mft_at : 0];
  // While a source is not valid, its payload is inverted: the top must not take it.
  wire [127:0] s_axis_mft_tdata;
  wire [0:0] s_axis_mft_tlast;
  assign {
      s_axis_mft_tdata, s_axis_mft_tlast
    } = s_axis_mft_tvalid ? s_axis_mft_word : ~s_axis_mft_word;

  // m_axis_feat, from gather_feat.hex: tdata 128, tkeep 16, tlast 1, tuser 16
  reg [160:0] m_axis_feat_words [0:1531];
  integer m_axis_feat_at = 0;
  integer m_axis_feat_ends = 0;  // of packets that were taken
  reg m_axis_feat_held = 1'b0;
  reg m_axis_feat_tready = 1'b0;
  wire m_axis_feat_tvalid;
  wire [161-1:0] m_axis_feat_found;
  wire [127:0] m_axis_feat_tdata;
  wire [15:0] m_axis_feat_tkeep;
  wire [0:0] m_axis_feat_tlast;
  wire [15:0] m_axis_feat_tuser;
  assign m_axis_feat_found = {
      m_axis_feat_tdata, m_axis_feat_tkeep, m_axis_feat_tlast, m_axis_feat_tuser
    };

  integer vu_job = 0;
  localparam VU_JOBS = 15;

  // vu_job, from vector_jobs.hex: s_axis_vec_from 32, s_axis_vec_end 32, m_axis_vec_from 32,
  // m_axis_vec_end 32, closed 16, cycles 32, stat_vectors 32, stat_busy 32, stat_stall_out 32,
  // stat_errors 3
  reg [274:0] vu_job_words [0:17];
  wire [31:0] vu_job_s_axis_vec_from;
  wire [31:0] vu_job_s_axis_vec_end;
  wire [31:0] vu_job_m_axis_vec_from;
  wire [31:0] vu_job_m_axis_vec_end;
  wire [15:0] vu_job_closed;
  wire [31:0] vu_job_cycles;
  wire [31:0] vu_job_stat_vectors;
  wire [31:0] vu_job_stat_busy;
  wire [31:0] vu_job_stat_stall_out;
  wire [2:0] vu_job_stat_errors;
  assign {
      vu_job_s_axis_vec_from, vu_job_s_axis_vec_end, vu_job_m_axis_vec_from,
      vu_job_m_axis_vec_end, vu_job_closed, vu_job_cycles, vu_job_stat_vectors, vu_job_stat_busy,
      vu_job_stat_stall_out, vu_job_stat_errors
    } = vu_job_words[vu_job];

  // s_axis_vec, from vector_in.hex: tdata 256, tkeep 32, tlast 1, tuser 12
  reg [300:0] s_axis_vec_words [0:605];
  integer s_axis_vec_job = 0;  // whose beats are offered
  integer s_axis_vec_at = 0;
  integer s_axis_vec_next;
  reg s_axis_vec_moved;
  reg s_axis_vec_tvalid = 1'b0;
  wire s_axis_vec_tready;
  wire [301-1:0] s_axis_vec_word = s_axis_vec_words[s_axis_vec_at < 606 ? s_axis_vec_at : 0];
  // While a source is not valid, its payload is inverted: the top must not take it.
  wire [255:0] s_axis_vec_tdata;
  wire [31:0] s_axis_vec_tkeep;
  wire [0:0] s_axis_vec_tlast;
  wire [11:0] s_axis_vec_tuser;
  assign {
      s_axis_vec_tdata, s_axis_vec_tkeep, s_axis_vec_tlast, s_axis_vec_tuser
    } = s_axis_vec_tvalid ? s_axis_vec_word : ~s_axis_vec_word;

  // m_axis_vec, from vector_out.hex: tdata 128, tkeep 16, tlast 1
  reg [144:0] m_axis_vec_words [0:602];
  integer m_axis_vec_at = 0;
  integer m_axis_vec_ends = 0;  // of packets that were taken
  reg m_axis_vec_held = 1'b0;
  reg m_axis_vec_tready = 1'b0;
  wire m_axis_vec_tvalid;
  wire [145-1:0] m_axis_vec_found;
  wire [127:0] m_axis_vec_tdata;
  wire [15:0] m_axis_vec_tkeep;
  wire [0:0] m_axis_vec_tlast;
  assign m_axis_vec_found = {
      m_axis_vec_tdata, m_axis_vec_tkeep, m_axis_vec_tlast
    };

  potamoi_npu_ext unit (
    .clk(clk),
    .rst_n(rst_n),
    .s_axil_awaddr(s_axil_awaddr),
    .s_axil_awprot(s_axil_awprot),
    .s_axil_awvalid(s_axil_awvalid),
    .s_axil_wdata(s_axil_wdata),
    .s_axil_wstrb(s_axil_wstrb),
    .s_axil_wvalid(s_axil_wvalid),
    .s_axil_bready(s_axil_bready),
    .s_axil_araddr(s_axil_araddr),
    .s_axil_arprot(s_axil_arprot),
    .s_axil_arvalid(s_axil_arvalid),
    .s_axil_rready(s_axil_rready),
    .s_axis_rit_tvalid(s_axis_rit_tvalid),
    .s_axis_rit_tdata(s_axis_rit_tdata),
    .s_axis_rit_tkeep(s_axis_rit_tkeep),
    .s_axis_rit_tlast(s_axis_rit_tlast),
    .s_axis_rit_tuser(s_axis_rit_tuser),
    .s_axis_mft_tvalid(s_axis_mft_tvalid),
    .s_axis_mft_tdata(s_axis_mft_tdata),
    .s_axis_mft_tlast(s_axis_mft_tlast),
    .m_axis_feat_tready(m_axis_feat_tready),
    .s_axis_vec_tvalid(s_axis_vec_tvalid),
    .s_axis_vec_tdata(s_axis_vec_tdata),
    .s_axis_vec_tkeep(s_axis_vec_tkeep),
    .s_axis_vec_tlast(s_axis_vec_tlast),
    .s_axis_vec_tuser(s_axis_vec_tuser),
    .m_axis_vec_tready(m_axis_vec_tready),
    .s_axil_awready(s_axil_awready),
    .s_axil_wready(s_axil_wready),
    .s_axil_bvalid(s_axil_bvalid),
    .s_axil_bresp(s_axil_bresp),
    .s_axil_arready(s_axil_arready),
    .s_axil_rvalid(s_axil_rvalid),
    .s_axil_rdata(s_axil_rdata),
    .s_axil_rresp(s_axil_rresp),
    .s_axis_rit_tready(s_axis_rit_tready),
    .s_axis_mft_tready(s_axis_mft_tready),
    .m_axis_feat_tvalid(m_axis_feat_tvalid),
    .m_axis_feat_tdata(m_axis_feat_tdata),
    .m_axis_feat_tkeep(m_axis_feat_tkeep),
    .m_axis_feat_tlast(m_axis_feat_tlast),
    .m_axis_feat_tuser(m_axis_feat_tuser),
    .s_axis_vec_tready(s_axis_vec_tready),
    .m_axis_vec_tvalid(m_axis_vec_tvalid),
    .m_axis_vec_tdata(m_axis_vec_tdata),
    .m_axis_vec_tkeep(m_axis_vec_tkeep),
    .m_axis_vec_tlast(m_axis_vec_tlast),
    .irq(irq)
  );

  task fail;
    begin
      if (!failed) $display("  round %0d, +gaps=%0d +seed=%0d", round, gaps, seed);
      failed = 1'b1;
`ifdef __ICARUS__
      $finish_and_return(1);
`else
      $fatal(1);
`endif
    end
  endtask

  // Clocks of a pause of the bus.
  integer pause;
  task draw_pause;
    begin
      pause = 0;
      bus_drawn = after(bus_drawn);
      while (bus_drawn[30:8] % 100 < gaps && pause < 12) begin
        pause = pause + 1;
        bus_drawn = after(bus_drawn);
      end
    end
  endtask

  // The bus moves at falling edges, so that its order with the registers' clock edge does not matter.
  integer waited;
  integer address_wait;
  integer data_wait;
  reg has_address;
  reg has_data;
  reg meets;
  reg meets_data;
  reg [1:0] response;
  task write(input [11:0] address, input [31:0] data, input [3:0] strobe, input [1:0] expected);
    begin
      has_address = 1'b0;
      has_data = 1'b0;
      draw_pause;
      address_wait = pause;
      draw_pause;
      data_wait = pause;
      waited = 0;
      while (!failed && !(has_address && has_data)) begin
        if (waited == address_wait) begin
          s_axil_awaddr = address;
          s_axil_awvalid = 1'b1;
        end
        if (waited == data_wait) begin
          s_axil_wdata = data;
          s_axil_wstrb = strobe;
          s_axil_wvalid = 1'b1;
        end
        meets = s_axil_awvalid && s_axil_awready === 1'b1;
        meets_data = s_axil_wvalid && s_axil_wready === 1'b1;
        if (!failed && s_axil_bvalid !== 1'b0) begin
          $display("FAIL: a write to %h is answered before it was taken", address);
          fail;
        end
        if (!failed && (has_address && s_axil_awready !== 1'b0 || has_data && s_axil_wready !== 1'b0)) begin
          $display("FAIL: a further write could enter before that to %h was answered", address);
          fail;
        end
        @(negedge clk);
        // Afterwards the payload is another one, which must not be taken.
        if (meets) begin
          has_address = 1'b1;
          s_axil_awvalid = 1'b0;
          s_axil_awaddr = ~address;
        end
        if (meets_data) begin
          has_data = 1'b1;
          s_axil_wvalid = 1'b0;
          s_axil_wdata = ~data;
          s_axil_wstrb = ~strobe;
        end
        waited = waited + 1;
        if (!failed && waited > 1000) begin
          $display("FAIL: a write to %h was not taken", address);
          fail;
        end
      end
      draw_pause;
      repeat (pause) @(negedge clk);
      s_axil_bready = 1'b1;
      meets = 1'b0;
      waited = 0;
      while (!failed && !meets) begin
        if (s_axil_awready !== 1'b0 || s_axil_wready !== 1'b0) begin
          $display("FAIL: a further write could enter before that to %h was answered", address);
          fail;
        end
        meets = s_axil_bvalid === 1'b1;
        response = s_axil_bresp;
        @(negedge clk);
        waited = waited + 1;
        if (!failed && waited > 1000) begin
          $display("FAIL: a write to %h has no response", address);
          fail;
        end
      end
      s_axil_bready = 1'b0;
      if (!failed && response !== expected) begin
        $display("FAIL: a write to %h has the response %0d, expected %0d", address, response, expected);
        fail;
      end
    end
  endtask

  reg [31:0] word;  // that was read
  task read(input [11:0] address, input [1:0] expected);
    begin
      draw_pause;
      repeat (pause) @(negedge clk);
      s_axil_araddr = address;
      s_axil_arvalid = 1'b1;
      meets = 1'b0;
      waited = 0;
      while (!failed && !meets) begin
        if (s_axil_rvalid !== 1'b0) begin
          $display("FAIL: a read of %h is answered before it was taken", address);
          fail;
        end
        meets = s_axil_arready === 1'b1;
        @(negedge clk);
        waited = waited + 1;
        if (!failed && waited > 1000) begin
          $display("FAIL: a read of %h was not taken", address);
          fail;
        end
      end
      s_axil_arvalid = 1'b0;
      s_axil_araddr = ~address;
      draw_pause;
      repeat (pause) @(negedge clk);
      s_axil_rready = 1'b1;
      meets = 1'b0;
      waited = 0;
      while (!failed && !meets) begin
        if (!failed && s_axil_arready !== 1'b0) begin
          $display("FAIL: a further read could enter before that of %h was answered", address);
          fail;
        end
        meets = s_axil_rvalid === 1'b1;
        response = s_axil_rresp;
        word = s_axil_rdata;
        @(negedge clk);
        waited = waited + 1;
        if (!failed && waited > 1000) begin
          $display("FAIL: a read of %h has no response", address);
          fail;
        end
      end
      s_axil_rready = 1'b0;
      if (!failed && response !== expected) begin
        $display("FAIL: a read of %h has the response %0d, expected %0d", address, response, expected);
        fail;
      end
    end
  endtask

  task check(input [11:0] address, input [31:0] expected);
    begin
      if (!failed) read(address, OKAY);
      if (!failed && word !== expected) begin
        $display("FAIL: register %h is %h, expected %h", address, word, expected);
        fail;
      end
    end
  endtask

  always @(posedge clk) if (!failed) begin
    if (!rst_n) begin
      if (s_axis_rit_tready !== 1'b0 && $time > 0) begin
        $display("FAIL: s_axis_rit_tready is %b in reset", s_axis_rit_tready);
        fail;
      end
      s_axis_rit_job = gu_first;
      s_axis_rit_at <= gu_job_words[gu_first][408:377];
      s_axis_rit_tvalid <= 1'b0;
    end else begin
      s_axis_rit_moved = s_axis_rit_tvalid && s_axis_rit_tready === 1'b1;
      s_axis_rit_next = s_axis_rit_at;
      if (s_axis_rit_moved) begin
        s_axis_rit_next = s_axis_rit_at + 1;
        quiet = 0;
      end
      while (s_axis_rit_job + 1 < GU_JOBS && s_axis_rit_next == gu_job_words[s_axis_rit_job][376:345]) begin
        s_axis_rit_job = s_axis_rit_job + 1;
        s_axis_rit_next = gu_job_words[s_axis_rit_job][408:377];
      end
      drawn = after(drawn);
      s_axis_rit_at <= s_axis_rit_next;
      s_axis_rit_tvalid <= s_axis_rit_next != gu_job_words[s_axis_rit_job][376:345]
        && (drawn[30:8] % 100 >= gaps || (s_axis_rit_tvalid && !s_axis_rit_moved));
    end
    if (!rst_n) begin
      if (s_axis_mft_tready !== 1'b0 && $time > 0) begin
        $display("FAIL: s_axis_mft_tready is %b in reset", s_axis_mft_tready);
        fail;
      end
      s_axis_mft_job = gu_first;
      s_axis_mft_at <= gu_job_words[gu_first][344:313];
      s_axis_mft_tvalid <= 1'b0;
    end else begin
      s_axis_mft_moved = s_axis_mft_tvalid && s_axis_mft_tready === 1'b1;
      s_axis_mft_next = s_axis_mft_at;
      if (s_axis_mft_moved) begin
        s_axis_mft_next = s_axis_mft_at + 1;
        quiet = 0;
      end
      while (s_axis_mft_job + 1 < GU_JOBS && s_axis_mft_next == gu_job_words[s_axis_mft_job][312:281]) begin
        s_axis_mft_job = s_axis_mft_job + 1;
        s_axis_mft_next = gu_job_words[s_axis_mft_job][344:313];
      end
      drawn = after(drawn);
      s_axis_mft_at <= s_axis_mft_next;
      s_axis_mft_tvalid <= s_axis_mft_next != gu_job_words[s_axis_mft_job][312:281]
        && (drawn[30:8] % 100 >= gaps || (s_axis_mft_tvalid && !s_axis_mft_moved));
    end
    drawn = after(drawn);
    if (!rst_n) begin
      m_axis_feat_at = gu_job_m_axis_feat_from;
      m_axis_feat_ends = 0;
      m_axis_feat_held = 1'b0;
      m_axis_feat_tready <= 1'b0;
    end else begin
      if (m_axis_feat_tvalid !== 1'b0 && m_axis_feat_tvalid !== 1'b1) begin
        $display("FAIL: m_axis_feat_tvalid is %b", m_axis_feat_tvalid);
        fail;
      end else if (m_axis_feat_held && !m_axis_feat_tvalid) begin
        $display("FAIL: m_axis_feat_tvalid fell before beat %0d was taken", m_axis_feat_at);
        fail;
      end else if (m_axis_feat_tvalid && many == 32'd0 && m_axis_feat_at == gu_job_m_axis_feat_end) begin
        $display("FAIL: a surplus beat of m_axis_feat");
        fail;
      // A job of many packets takes beats of the next one, whose settings are others.
      end else if (m_axis_feat_tvalid && m_axis_feat_at < gu_job_m_axis_feat_end
          && m_axis_feat_found !== m_axis_feat_words[m_axis_feat_at]) begin
        $display("FAIL: beat %0d of m_axis_feat is %h, expected %h", m_axis_feat_at, m_axis_feat_found,
          m_axis_feat_words[m_axis_feat_at]);
        fail;
      end
      m_axis_feat_held = m_axis_feat_tvalid && !m_axis_feat_tready;
      if (m_axis_feat_tvalid && m_axis_feat_tready) begin
        m_axis_feat_at = m_axis_feat_at + 1;
        if (m_axis_feat_tlast === 1'b1) m_axis_feat_ends = m_axis_feat_ends + 1;
        quiet = 0;
      end
      m_axis_feat_tready <= drawn[30:8] % 100 >= gaps;
    end
    if (!rst_n) begin
      if (s_axis_vec_tready !== 1'b0 && $time > 0) begin
        $display("FAIL: s_axis_vec_tready is %b in reset", s_axis_vec_tready);
        fail;
      end
      s_axis_vec_job = vu_first;
      s_axis_vec_at <= vu_job_words[vu_first][274:243];
      s_axis_vec_tvalid <= 1'b0;
    end else begin
      s_axis_vec_moved = s_axis_vec_tvalid && s_axis_vec_tready === 1'b1;
      s_axis_vec_next = s_axis_vec_at;
      if (s_axis_vec_moved) begin
        s_axis_vec_next = s_axis_vec_at + 1;
        quiet = 0;
      end
      while (s_axis_vec_job + 1 < VU_JOBS && s_axis_vec_next == vu_job_words[s_axis_vec_job][242:211]) begin
        s_axis_vec_job = s_axis_vec_job + 1;
        s_axis_vec_next = vu_job_words[s_axis_vec_job][274:243];
      end
      drawn = after(drawn);
      s_axis_vec_at <= s_axis_vec_next;
      s_axis_vec_tvalid <= s_axis_vec_next != vu_job_words[s_axis_vec_job][242:211]
        && (drawn[30:8] % 100 >= gaps || (s_axis_vec_tvalid && !s_axis_vec_moved));
    end
    drawn = after(drawn);
    if (!rst_n) begin
      m_axis_vec_at = vu_job_m_axis_vec_from;
      m_axis_vec_ends = 0;
      m_axis_vec_held = 1'b0;
      m_axis_vec_tready <= 1'b0;
    end else begin
      if (m_axis_vec_tvalid !== 1'b0 && m_axis_vec_tvalid !== 1'b1) begin
        $display("FAIL: m_axis_vec_tvalid is %b", m_axis_vec_tvalid);
        fail;
      end else if (m_axis_vec_held && !m_axis_vec_tvalid) begin
        $display("FAIL: m_axis_vec_tvalid fell before beat %0d was taken", m_axis_vec_at);
        fail;
      end else if (m_axis_vec_tvalid && many == 32'd0 && m_axis_vec_at == vu_job_m_axis_vec_end) begin
        $display("FAIL: a surplus beat of m_axis_vec");
        fail;
      // A job of many packets takes beats of the next one, whose settings are others.
      end else if (m_axis_vec_tvalid && m_axis_vec_at < vu_job_m_axis_vec_end
          && m_axis_vec_found !== m_axis_vec_words[m_axis_vec_at]) begin
        $display("FAIL: beat %0d of m_axis_vec is %h, expected %h", m_axis_vec_at, m_axis_vec_found,
          m_axis_vec_words[m_axis_vec_at]);
        fail;
      end
      m_axis_vec_held = m_axis_vec_tvalid && !m_axis_vec_tready;
      if (m_axis_vec_tvalid && m_axis_vec_tready) begin
        m_axis_vec_at = m_axis_vec_at + 1;
        if (m_axis_vec_tlast === 1'b1) m_axis_vec_ends = m_axis_vec_ends + 1;
        quiet = 0;
      end
      m_axis_vec_tready <= drawn[30:8] % 100 >= gaps;
    end
  end

  // Every register after reset, what a write changes, and what it must not.
  task check_registers;
    begin
      check(ID, 32'h504f5441);
      write(ID, 32'hffffffff, 4'hf, SLVERR);
      check(ID, 32'h504f5441);
      check(VERSION, 32'h00010000);
      write(VERSION, 32'hffffffff, 4'hf, SLVERR);
      check(VERSION, 32'h00010000);
      check(CONFIG_LOW, 32'h530a3aa6);
      write(CONFIG_LOW, 32'hffffffff, 4'hf, SLVERR);
      check(CONFIG_LOW, 32'h530a3aa6);
      check(CONFIG_HIGH, 32'h0000e07f);
      write(CONFIG_HIGH, 32'hffffffff, 4'hf, SLVERR);
      check(CONFIG_HIGH, 32'h0000e07f);
      check(GU_PARAMS, 32'h0f10f108);
      write(GU_PARAMS, 32'hffffffff, 4'hf, SLVERR);
      check(GU_PARAMS, 32'h0f10f108);
      check(GU_LIMITS, 32'h08000200);
      write(GU_LIMITS, 32'hffffffff, 4'hf, SLVERR);
      check(GU_LIMITS, 32'h08000200);
      check(GU_STREAMS, 32'h01004008);
      write(GU_STREAMS, 32'hffffffff, 4'hf, SLVERR);
      check(GU_STREAMS, 32'h01004008);
      check(VU_PARAMS, 32'h1007f004);
      write(VU_PARAMS, 32'hffffffff, 4'hf, SLVERR);
      check(VU_PARAMS, 32'h1007f004);
      check(CONTROL, 32'h00000000);
      write(CONTROL, 32'hffffffff, 4'h0, OKAY);
      check(CONTROL, 32'h00000000);
      check(STATUS, 32'h0000000c);
      write(STATUS, 32'hffffffff, 4'hf, SLVERR);
      check(STATUS, 32'h0000000c);
      check(IRQ_STATUS, 32'h00000000);
      write(IRQ_STATUS, 32'hffffffff, 4'h0, OKAY);
      check(IRQ_STATUS, 32'h00000000);
      check(IRQ_ENABLE, 32'h00000000);
      write(IRQ_ENABLE, 32'ha5c3965a, 4'h1, OKAY);
      check(IRQ_ENABLE, 32'h0000001a);
      write(IRQ_ENABLE, 32'ha5c3965a, 4'h2, OKAY);
      check(IRQ_ENABLE, 32'h0000001a);
      write(IRQ_ENABLE, 32'ha5c3965a, 4'h4, OKAY);
      check(IRQ_ENABLE, 32'h0000001a);
      write(IRQ_ENABLE, 32'ha5c3965a, 4'h8, OKAY);
      check(IRQ_ENABLE, 32'h0000001a);
      write(IRQ_ENABLE, 32'h00000000, 4'hf, OKAY);
      check(GU_MODE, 32'h00000100);
      write(GU_MODE, 32'ha5c3965a, 4'h1, OKAY);
      check(GU_MODE, 32'h00000102);
      write(GU_MODE, 32'ha5c3965a, 4'h2, OKAY);
      check(GU_MODE, 32'h00001602);
      write(GU_MODE, 32'ha5c3965a, 4'h4, OKAY);
      check(GU_MODE, 32'h00001602);
      write(GU_MODE, 32'ha5c3965a, 4'h8, OKAY);
      check(GU_MODE, 32'h00001602);
      write(GU_MODE, 32'h00000100, 4'hf, OKAY);
      check(GU_PACKETS, 32'h00000000);
      write(GU_PACKETS, 32'ha5c3965a, 4'h1, OKAY);
      check(GU_PACKETS, 32'h0000005a);
      write(GU_PACKETS, 32'ha5c3965a, 4'h2, OKAY);
      check(GU_PACKETS, 32'h0000965a);
      write(GU_PACKETS, 32'ha5c3965a, 4'h4, OKAY);
      check(GU_PACKETS, 32'h00c3965a);
      write(GU_PACKETS, 32'ha5c3965a, 4'h8, OKAY);
      check(GU_PACKETS, 32'ha5c3965a);
      write(GU_PACKETS, 32'h00000000, 4'hf, OKAY);
      check(GU_LEFT, 32'h00000000);
      write(GU_LEFT, 32'hffffffff, 4'hf, SLVERR);
      check(GU_LEFT, 32'h00000000);
      check(GU_ERRORS, 32'h00000000);
      write(GU_ERRORS, 32'hffffffff, 4'hf, SLVERR);
      check(GU_ERRORS, 32'h00000000);
      check(VU_PACKETS, 32'h00000000);
      write(VU_PACKETS, 32'ha5c3965a, 4'h1, OKAY);
      check(VU_PACKETS, 32'h0000005a);
      write(VU_PACKETS, 32'ha5c3965a, 4'h2, OKAY);
      check(VU_PACKETS, 32'h0000965a);
      write(VU_PACKETS, 32'ha5c3965a, 4'h4, OKAY);
      check(VU_PACKETS, 32'h00c3965a);
      write(VU_PACKETS, 32'ha5c3965a, 4'h8, OKAY);
      check(VU_PACKETS, 32'ha5c3965a);
      write(VU_PACKETS, 32'h00000000, 4'hf, OKAY);
      check(VU_LEFT, 32'h00000000);
      write(VU_LEFT, 32'hffffffff, 4'hf, SLVERR);
      check(VU_LEFT, 32'h00000000);
      check(VU_ERRORS, 32'h00000000);
      write(VU_ERRORS, 32'hffffffff, 4'hf, SLVERR);
      check(VU_ERRORS, 32'h00000000);
      check(GU_BUSY, 32'h00000000);
      write(GU_BUSY, 32'hffffffff, 4'hf, SLVERR);
      check(GU_BUSY, 32'h00000000);
      check(GU_STALL_FIFO, 32'h00000000);
      write(GU_STALL_FIFO, 32'hffffffff, 4'hf, SLVERR);
      check(GU_STALL_FIFO, 32'h00000000);
      check(GU_STALL_MFT, 32'h00000000);
      write(GU_STALL_MFT, 32'hffffffff, 4'hf, SLVERR);
      check(GU_STALL_MFT, 32'h00000000);
      check(GU_STALL_RIT, 32'h00000000);
      write(GU_STALL_RIT, 32'hffffffff, 4'hf, SLVERR);
      check(GU_STALL_RIT, 32'h00000000);
      check(GU_ENTRIES, 32'h00000000);
      write(GU_ENTRIES, 32'hffffffff, 4'hf, SLVERR);
      check(GU_ENTRIES, 32'h00000000);
      check(VU_VECTORS, 32'h00000000);
      write(VU_VECTORS, 32'hffffffff, 4'hf, SLVERR);
      check(VU_VECTORS, 32'h00000000);
      check(VU_BUSY, 32'h00000000);
      write(VU_BUSY, 32'hffffffff, 4'hf, SLVERR);
      check(VU_BUSY, 32'h00000000);
      check(VU_STALL_OUT, 32'h00000000);
      write(VU_STALL_OUT, 32'hffffffff, 4'hf, SLVERR);
      check(VU_STALL_OUT, 32'h00000000);
      write(12'h030, 32'hffffffff, 4'hf, SLVERR);
      write(12'hffc, 32'hffffffff, 4'hf, SLVERR);
    end
  endtask

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
      read_hole('h030, 'h03c);
      read_hole('h05c, 'h0fc);
      read_hole('h104, 'h104);
      read_hole('h10c, 'h10c);
      read_hole('h114, 'h114);
      read_hole('h11c, 'h124);
      read_hole('h12c, 'h17c);
      read_hole('h184, 'h184);
      read_hole('h18c, 'h18c);
      read_hole('h194, 'hffc);
    end
  endtask

  integer gu_packets;
  integer gu_beat;
  task gu_begin;
    begin
      m_axis_feat_at = gu_job_m_axis_feat_from;
      // Ends of packets that the job must give.
      gu_packets = 0;
      for (gu_beat = m_axis_feat_at; gu_beat < gu_job_m_axis_feat_end; gu_beat = gu_beat + 1)
        if (m_axis_feat_words[gu_beat][16]) gu_packets = gu_packets + 1;
      mode = 32'd0;
      mode[0 +: 2] = gu_job_cfg_vertices;
      mode[8 +: 7] = gu_job_cfg_segments;
      write(GU_MODE, mode, 4'hf, OKAY);
      if (many != 32'd0) gu_packets = many;
      write(GU_PACKETS, gu_packets, 4'hf, OKAY);
      write(CONTROL, CONTROL_GU_START, 4'hf, OKAY);
      // Of the next job: the one that runs has its own.
      write(GU_MODE, ~mode, 4'hf, OKAY);
    end
  endtask

  task gu_check;
    begin
      if (!failed && m_axis_feat_at != gu_job_m_axis_feat_end) begin
        $display("FAIL: the job is done, and m_axis_feat gave %0d of %0d beats", m_axis_feat_at, gu_job_m_axis_feat_end);
        fail;
      end
      check(GU_BUSY, gu_job_stat_busy[31:0]);
      if (gaps == 0 && gu_job_closed == 0) check(GU_STALL_FIFO, gu_job_stat_stall_fifo[31:0]);
      if (gaps == 0 && gu_job_closed == 0) check(GU_STALL_MFT, gu_job_stat_stall_mft[31:0]);
      if (gaps == 0 && gu_job_closed == 0) check(GU_STALL_RIT, gu_job_stat_stall_rit[31:0]);
      check(GU_ENTRIES, gu_job_stat_entries[31:0]);
      check(GU_ERRORS, gu_job_stat_errors[8:0]);
    end
  endtask

  integer vu_packets;
  integer vu_beat;
  task vu_begin;
    begin
      m_axis_vec_at = vu_job_m_axis_vec_from;
      // Ends of packets that the job must give.
      vu_packets = 0;
      for (vu_beat = m_axis_vec_at; vu_beat < vu_job_m_axis_vec_end; vu_beat = vu_beat + 1)
        if (m_axis_vec_words[vu_beat][0]) vu_packets = vu_packets + 1;
      if (many != 32'd0) vu_packets = many;
      write(VU_PACKETS, vu_packets, 4'hf, OKAY);
      write(CONTROL, CONTROL_VU_START, 4'hf, OKAY);
    end
  endtask

  task vu_check;
    begin
      if (!failed && m_axis_vec_at != vu_job_m_axis_vec_end) begin
        $display("FAIL: the job is done, and m_axis_vec gave %0d of %0d beats", m_axis_vec_at, vu_job_m_axis_vec_end);
        fail;
      end
      check(VU_VECTORS, vu_job_stat_vectors[31:0]);
      if (gaps == 0 && vu_job_closed == 0) check(VU_BUSY, vu_job_stat_busy[31:0]);
      if (gaps == 0 && vu_job_closed == 0) check(VU_STALL_OUT, vu_job_stat_stall_out[31:0]);
      check(VU_ERRORS, vu_job_stat_errors[2:0]);
    end
  endtask

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
        while (!failed && (s_axis_rit_at == 0 || s_axis_mft_at == 0 || s_axis_vec_at == 0)) begin
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

  // The beats of a job that break a promise raise flags, which interrupt until they are cleared.
  task gu_break(input integer number, input [31:0] up, input [31:0] down);
    begin
      gu_first = number;
      gu_job = number;
      reset;
      many = 32'd1 << 31;
      gu_begin;
      quiet = 0;
      while (!failed && (s_axis_rit_at != gu_job_s_axis_rit_end || s_axis_mft_at != gu_job_s_axis_mft_end)) begin
        @(negedge clk);
        quiet = quiet + 1;
        if (quiet > PATIENCE) begin
          $display("FAIL: no beat for %0d clocks, and job %0d is not taken", quiet, number);
          fail;
        end
      end
      repeat (SHOWN) @(negedge clk);
      read(GU_ERRORS, OKAY);
      if (!failed && ((word & up) != up || (word & down) != 0)) begin
        $display("FAIL: register %h is %b after job %0d: expected %b up, %b down",
          GU_ERRORS, word, number, up, down);
        fail;
      end
      read(IRQ_STATUS, OKAY);
      if (!failed && (word & IRQ_STATUS_GU_ERROR) == 0) begin
        $display("FAIL: no event of the flags %b", up);
        fail;
      end
      interrupts(IRQ_STATUS_GU_ERROR);
      write(CONTROL, CONTROL_CLEAR, 4'hf, OKAY);
      read(GU_ERRORS, OKAY);
      if (!failed && (word & up) != 0) begin
        $display("FAIL: flags %b are up after they were cleared", word);
        fail;
      end
      many = 32'd0;
      gu_first = 0;
    end
  endtask

  // The beats of a job that break a promise raise flags, which interrupt until they are cleared.
  task vu_break(input integer number, input [31:0] up, input [31:0] down);
    begin
      vu_first = number;
      vu_job = number;
      reset;
      many = 32'd1 << 31;
      vu_begin;
      quiet = 0;
      while (!failed && (s_axis_vec_at != vu_job_s_axis_vec_end)) begin
        @(negedge clk);
        quiet = quiet + 1;
        if (quiet > PATIENCE) begin
          $display("FAIL: no beat for %0d clocks, and job %0d is not taken", quiet, number);
          fail;
        end
      end
      repeat (SHOWN) @(negedge clk);
      read(VU_ERRORS, OKAY);
      if (!failed && ((word & up) != up || (word & down) != 0)) begin
        $display("FAIL: register %h is %b after job %0d: expected %b up, %b down",
          VU_ERRORS, word, number, up, down);
        fail;
      end
      read(IRQ_STATUS, OKAY);
      if (!failed && (word & IRQ_STATUS_VU_ERROR) == 0) begin
        $display("FAIL: no event of the flags %b", up);
        fail;
      end
      interrupts(IRQ_STATUS_VU_ERROR);
      write(CONTROL, CONTROL_CLEAR, 4'hf, OKAY);
      read(VU_ERRORS, OKAY);
      if (!failed && (word & up) != 0) begin
        $display("FAIL: flags %b are up after they were cleared", word);
        fail;
      end
      many = 32'd0;
      vu_first = 0;
    end
  endtask

  task break_promises;
    begin
      gu_break(69, 32'h8, 32'h1f7);
      gu_break(70, 32'h10, 32'h1e7);
      gu_break(71, 32'h20, 32'h1df);
      gu_break(72, 32'h40, 32'h1bf);
      gu_break(73, 32'h80, 32'h0);
      vu_break(15, 32'h2, 32'h5);
      vu_break(16, 32'h1, 32'h6);
      vu_break(17, 32'h4, 32'h3);
    end
  endtask

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
    bus_drawn = after(drawn);
    file = $fopen("gather_jobs.hex", "r");
    if (file == 0) begin
      if (!failed) $display("FAIL: gather_jobs.hex is missing: run in the folder of the .hex files");
      fail;
    end else begin
      $fclose(file);
      $readmemh("gather_jobs.hex", gu_job_words);
      if (^gu_job_words[73] === 1'bx) begin
        if (!failed) $display("FAIL: gather_jobs.hex has fewer words than this bench reads");
        fail;
      end
    end
    file = $fopen("gather_rit.hex", "r");
    if (file == 0) begin
      if (!failed) $display("FAIL: gather_rit.hex is missing: run in the folder of the .hex files");
      fail;
    end else begin
      $fclose(file);
      $readmemh("gather_rit.hex", s_axis_rit_words);
      if (^s_axis_rit_words[5795] === 1'bx) begin
        if (!failed) $display("FAIL: gather_rit.hex has fewer words than this bench reads");
        fail;
      end
    end
    file = $fopen("gather_mft.hex", "r");
    if (file == 0) begin
      if (!failed) $display("FAIL: gather_mft.hex is missing: run in the folder of the .hex files");
      fail;
    end else begin
      $fclose(file);
      $readmemh("gather_mft.hex", s_axis_mft_words);
      if (^s_axis_mft_words[1774] === 1'bx) begin
        if (!failed) $display("FAIL: gather_mft.hex has fewer words than this bench reads");
        fail;
      end
    end
    file = $fopen("gather_feat.hex", "r");
    if (file == 0) begin
      if (!failed) $display("FAIL: gather_feat.hex is missing: run in the folder of the .hex files");
      fail;
    end else begin
      $fclose(file);
      $readmemh("gather_feat.hex", m_axis_feat_words);
      if (^m_axis_feat_words[1531] === 1'bx) begin
        if (!failed) $display("FAIL: gather_feat.hex has fewer words than this bench reads");
        fail;
      end
    end
    file = $fopen("vector_jobs.hex", "r");
    if (file == 0) begin
      if (!failed) $display("FAIL: vector_jobs.hex is missing: run in the folder of the .hex files");
      fail;
    end else begin
      $fclose(file);
      $readmemh("vector_jobs.hex", vu_job_words);
      if (^vu_job_words[17] === 1'bx) begin
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
      if (^s_axis_vec_words[605] === 1'bx) begin
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
      if (^m_axis_vec_words[602] === 1'bx) begin
        if (!failed) $display("FAIL: vector_out.hex has fewer words than this bench reads");
        fail;
      end
    end

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
