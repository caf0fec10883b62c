// potamoi_free: any constant. A proof holds for all values; a simulation takes +pick=N, or 0.
`default_nettype none

module potamoi_free #(
  parameter WIDTH = 1
) (
  output wire [WIDTH-1:0] value
);

`ifdef FORMAL
  (* anyconst *) reg [WIDTH-1:0] chosen;
`else
  reg [31:0] number;
  reg [WIDTH+31:0] wide;
  wire [WIDTH-1:0] chosen = wide[WIDTH-1:0];
  wire unused_ok = &{1'b0, wide[WIDTH+31:WIDTH]};

  initial begin
    if (!$value$plusargs("pick=%d", number)) number = 32'd0;
    wide = {{WIDTH{1'b0}}, number};
  end
`endif

  assign value = chosen;
endmodule

`default_nettype wire
