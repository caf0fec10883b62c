module lane(
    input  wire        clk,
    input  wire        en,
    input  wire [15:0] a,
    input  wire [15:0] b,
    input  wire [5:0]  raddr,
    output reg  [31:0] acc0,
    output reg  [31:0] acc1
);
    reg [31:0] bank [0:63];
    reg [31:0] weights [0:63];
    reg [31:0] rd, wt, p0, p1;
    reg [31:0] last0, last1, last2, peak;
    reg [5:0]  waddr;
    reg        en1, en2;
    integer i;
    initial begin
        for (i = 0; i < 64; i = i + 1) begin
            bank[i] = i * 32'h9e3779b9;
            weights[i] = i * 32'h85ebca6b;
        end
        rd = 0; wt = 0; last0 = 0; last1 = 0; last2 = 0; peak = 0; p0 = 0; p1 = 0; waddr = 0; en1 = 0; en2 = 0; acc0 = 0; acc1 = 0;
    end
    always @(posedge clk) begin
        rd  <= bank[raddr];
        wt  <= weights[raddr ^ waddr];
        en1 <= en;
        en2 <= en1;
        if (en) waddr <= waddr + 6'd1;
        if (en2) bank[waddr] <= acc0 ^ last2 ^ peak;
        if (p0 > peak) peak <= p0;
        else if (en) peak <= peak >> 1;
        if (en2) begin
            last0 <= acc1;
            last1 <= last0;
            last2 <= last1;
        end
        if (en1) begin
            p0 <= {16'd0, a} * {16'd0, rd[15:0] ^ wt[31:16]};
            p1 <= {16'd0, b} * {16'd0, rd[31:16] ^ wt[15:0]};
        end
        if (en2) begin
            acc0 <= acc0 + p0;
            acc1 <= p1[31] ? acc1 - p1 : acc1 + p1;
        end
    end
endmodule
