// potamoi_checking: tells when checks count: out of reset, once there has been a reset. A proof
// begins with one.
`default_nettype none

module potamoi_checking (
  input  wire clk,
  input  wire rst_n,
  output wire on
);

  reg begun;
  initial begun = 1'b0;

`ifdef FORMAL
  always @(posedge clk) begun <= 1'b1;

  always @(*) begin
    if (!begun) first: assume (!rst_n);
  end
`else
  always @(posedge clk) begin
    if (!rst_n) begun <= 1'b1;
  end
`endif

  assign on = begun & rst_n;
endmodule

`default_nettype wire
