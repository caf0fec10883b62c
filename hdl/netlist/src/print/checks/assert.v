// potamoi_assert: a condition that always holds. A simulation stops where it does not. With TAKES_X
// it goes on where the condition is unknown: a module without reset is shown unknown operands
// before the first valid one.
`default_nettype none

module potamoi_assert #(
  parameter TAKES_X = 0
) (
  input wire clk,
  input wire on,
  input wire good
);

`ifdef FORMAL
  always @(*) begin
    if (on) holds: assert (good);
  end

  wire unused_ok = &{1'b0, clk, TAKES_X != 0};
`else
  always @(posedge clk) begin
    if (on && good !== 1'b1 && (TAKES_X == 0 || good === 1'b0)) begin
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
