// potamoi_begun: tells when checks of a module without a reset count: from the second clock edge
// on, when registers that hold what was at the last edge have been written.
`default_nettype none

module potamoi_begun (
  input  wire clk,
  output wire on
);

  reg begun;
  initial begun = 1'b0;

  always @(posedge clk) begun <= 1'b1;

  assign on = begun;
endmodule

`default_nettype wire
