//! The bus in the bench of the SoC top: tasks that write, read and check a register.

pub(super) const TASKS: &str = r#"
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
"#;
