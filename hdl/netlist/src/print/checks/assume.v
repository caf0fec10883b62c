// potamoi_assume: what the design expects of its inputs. A proof takes it for granted, a simulation
// stops where it does not hold.
`default_nettype none

module potamoi_assume (
  input wire clk,
  input wire on,
  input wire good
);

`ifdef FORMAL
  always @(*) begin
    if (on) given: assume (good);
  end

  wire unused_ok = &{1'b0, clk};
`else
  always @(posedge clk) begin
    if (on && good !== 1'b1 && !$test$plusargs("any_input")) begin
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
