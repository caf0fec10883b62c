// potamoi_same: whether two payloads are the same. With TAKES_X, X is the same as X. With
// POTAMOI_ONE_BIT a proof compares bit 0 alone, unless WHOLE is 1: it stands for all where
// registers and memories between the two treat all bits alike, and nothing is seen of a fault of
// another bit.
`default_nettype none

module potamoi_same #(
  parameter WIDTH = 1,
  parameter WHOLE = 0,
  parameter TAKES_X = 0
) (
  input  wire [WIDTH-1:0] a,
  input  wire [WIDTH-1:0] b,
  output wire             same
);

`ifdef POTAMOI_ONE_BIT
  assign same = WHOLE ? a == b : a[0] == b[0];

  wire unused_ok = &{1'b0, a, b};
`else
  assign same = TAKES_X ? a === b : a == b;

  wire unused_ok = &{1'b0, WHOLE != 0};
`endif
endmodule

`default_nettype wire
