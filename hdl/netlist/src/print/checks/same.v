// potamoi_same: whether two payloads are the same. With POTAMOI_ONE_BIT a proof compares one bit,
// which stands for all: registers and memories between the two treat all bits alike.
`default_nettype none

module potamoi_same #(
  parameter WIDTH = 1
) (
  input  wire [WIDTH-1:0] a,
  input  wire [WIDTH-1:0] b,
  output wire             same
);

`ifdef POTAMOI_ONE_BIT
  assign same = a[0] == b[0];

  wire unused_ok = &{1'b0, a, b};
`else
  assign same = a == b;
`endif
endmodule

`default_nettype wire
