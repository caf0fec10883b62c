module macs(
    input  wire          clk,
    input  wire          valid,
    input  wire [11:0]   gain,
    input  wire [47:0]   tag,
    input  wire [511:0]  a,
    input  wire [511:0]  b,
    output reg           valid_q,
    output reg  [59:0]   tag_q,
    output reg  [1023:0] acc0,
    output reg  [1023:0] acc1
);
    integer i;
    initial begin
        valid_q = 0; tag_q = 0; acc0 = 0; acc1 = 0;
    end
    always @(posedge clk) begin
        valid_q <= valid;
        tag_q <= {gain, tag};
        for (i = 0; i < 32; i = i + 1) begin
            if (valid) begin
                acc0[32*i +: 32] <= acc0[32*i +: 32] + {16'd0, a[16*i +: 16]} * {16'd0, b[16*i +: 16]};
                acc1[32*i +: 32] <= acc1[32*i +: 32] ^ ({16'd0, a[16*i +: 16]} * {20'd0, gain});
            end
        end
    end
endmodule
