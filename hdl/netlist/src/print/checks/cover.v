// potamoi_cover: a condition that holds at some time. A simulation with +covers tells the first.
`default_nettype none

module potamoi_cover (
  input wire clk,
  input wire on,
  input wire good
);

`ifdef FORMAL
  always @(*) begin
    if (on) seen: cover (good);
  end

  wire unused_ok = &{1'b0, clk};
`else
  reg seen;
  initial seen = 1'b0;

  always @(posedge clk) begin
    if (on && good === 1'b1 && !seen) begin
      seen <= 1'b1;
      if ($test$plusargs("covers")) $display("%m is reached at %0t", $time);
    end
  end
`endif
endmodule

`default_nettype wire
