module gather(
    input  wire          clk,
    input  wire          valid,
    input  wire [11:0]   gain,
    input  wire [47:0]   tag,
    input  wire [511:0]  a,
    input  wire [511:0]  b,
    output reg  [59:0]   tag_q,
    output reg  [37:0]   total,
    output wire [511:0]  acc
);
    wire [511:0] low;
    wire [1023:0] high;
    genvar g;
    generate
        for (g = 0; g < 32; g = g + 1) begin : lanes
            wire [31:0] acc0;
            lane u(
                .clk(clk), .en(valid | a[16*g]),
                .a(a[16*g +: 16]), .b(b[16*g +: 16] ^ {4'd0, gain}),
                .raddr(a[16*g +: 6] ^ b[16*((g + 7) % 32) +: 6] ^ low[16*((g + 13) % 32) +: 6]),
                .acc0(acc0), .acc1(high[32*g +: 32]));
            assign low[16*g +: 16] = acc0[31:16] ^ acc0[15:0];
        end
    endgenerate
    assign acc = low;
    integer i;
    reg [37:0] sum;
    always @* begin
        sum = 0;
        for (i = 0; i < 32; i = i + 1) sum = sum + {6'd0, high[32*i +: 32]};
    end
    initial begin
        tag_q = 0; total = 0;
    end
    always @(posedge clk) begin
        tag_q <= {gain, tag};
        total <= sum;
    end
endmodule
