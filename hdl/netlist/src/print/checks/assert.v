// potamoi_assert: a condition that always holds. A simulation stops where it does not.
`default_nettype none

module potamoi_assert (
  input wire clk,
  input wire on,
  input wire good
);

`ifdef FORMAL
  always @(*) begin
    if (on) holds: assert (good);
  end

  wire unused_ok = &{1'b0, clk};
`else
  always @(posedge clk) begin
    if (on && good !== 1'b1) begin
      $display("FAIL: %m does not hold at %0t", $time);
`ifdef __ICARUS__
      $finish_and_return(1);
`else
      $fatal(1);
`endif
    end
  end
`endif
endmodule

`default_nettype wire
