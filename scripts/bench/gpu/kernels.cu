// The two row passes of the default solver and the passes over a spectrum, as in
// numba_kernels/. A block has 128 threads, a thread goes down a strip of 32 rows. n: points along a row, m = n/2.

#define THREADS 128
#define STRIP 32
typedef long long Index;

__device__ float decode(unsigned short stored)
{
    return __uint_as_float((unsigned int)stored << 16);
}

__device__ unsigned short encode(float number)
{
    return (unsigned short)(__float_as_uint(number) >> 16);
}

#define PROJECTED 0xFF80

__device__ float step_of(unsigned short stored, float g)
{
    return stored == PROJECTED ? -g : decode(stored);
}

__device__ unsigned short projected_point(
    float g, float p, unsigned short stored, float Pz, float length, float coupling, float beta)
{
    float d_last = stored == PROJECTED ? 0.f : decode(stored);
    float free_gap = g - length * (p + coupling * Pz) - beta * d_last;
    float g_new = fmaxf(free_gap, 0.f);
    unsigned short next = encode(g_new - g);
    if (g_new <= 0.f || decode(next) <= -g) next = PROJECTED;
    if (g <= 0.f && p > 0.f) next = 0;
    return next;
}

// Set partial[block, column] to the sum of a value over the threads of the block.
__device__ void sum_of_block(float value, double* partial, int columns, int column)
{
    __shared__ double warps[THREADS / 32];
    double sum = value;
    for (int k = 16; k > 0; k /= 2) sum += __shfl_down_sync(0xffffffffu, sum, k);
    __syncthreads();
    if (threadIdx.x % 32 == 0) warps[threadIdx.x / 32] = sum;
    __syncthreads();
    if (threadIdx.x == 0) {
        double total = 0;
        for (int k = 0; k < THREADS / 32; k++) total += warps[k];
        partial[((Index)blockIdx.y * gridDim.x + blockIdx.x) * columns + column] = total;
    }
}

extern "C" __global__ void __launch_bounds__(THREADS) step_rows(
    const float* __restrict__ g, const float* __restrict__ p, unsigned short* __restrict__ d,
    float* __restrict__ d_rows, Index i0, Index i1, const float* __restrict__ z, Index m,
    float alpha, float beta, float coupling, float compliance, double* partial)
{
    Index c = (Index)blockIdx.x * THREADS + threadIdx.x;
    Index start = i0 + (Index)blockIdx.y * STRIP;
    Index end = min(start + STRIP, i1);
    Index n = 2 * m;
    float length = alpha * compliance;
    float rd = 0;
    if (c < m) {
        Index next = c + 1 < m ? c + 1 : 0;
        float below = 0, right_below = 0;
        if (coupling > 0) {
            below = z[(start / 2 + 1) * m + c];
            right_below = z[(start / 2 + 1) * m + next];
        }
        for (Index i = start; i < end; i += 2) {
            float left = below, right = right_below;
            if (coupling > 0) {
                below = z[(i / 2 + 2) * m + c];
                right_below = z[(i / 2 + 2) * m + next];
            }
            float left_mean = .5f * (left + below);
            float right_mean = .5f * (right + right_below);
            for (int k = 0; k < 2; k++) {
                Index at = (i + k) * n + 2 * c;
                float2 G = *(const float2*)(g + at);
                float2 P = *(const float2*)(p + at);
                ushort2 D = *(ushort2*)(d + at);
                float a = k ? left_mean : left;
                float b = k ? .5f * (left_mean + right_mean) : .5f * (left + right);
                D.x = projected_point(G.x, P.x, D.x, a, length, coupling, beta);
                D.y = projected_point(G.y, P.y, D.y, b, length, coupling, beta);
                float2 step = make_float2(step_of(D.x, G.x), step_of(D.y, G.y));
                rd += P.x * step.x;
                rd += P.y * step.y;
                *(ushort2*)(d + at) = D;
                *(float2*)(d_rows + (at - i0 * n)) = step;
            }
        }
    }
    sum_of_block(rd, partial, 1, 0);
}

// What a point is after a step, and its part of the sums.
struct Point { float r, t, x; };

__device__ Point change_point(float& g, float& p, unsigned short stored, float Kd, float s, float* sums)
{
    float d = step_of(stored, g);
    float g_new = g + s * d;
    float p_new = p + s * Kd;
    g = g_new;
    p = p_new;
    bool closed = g_new <= 0;
    bool touches = closed && p_new > 0;
    Point point = {touches ? 0.f : p_new, touches ? 1.f : 0.f, touches ? 0.f : Kd};
    sums[0] += point.r * point.r;
    sums[1] += p_new * p_new;
    sums[2] += point.r * d;
    sums[3] += point.x * d;
    sums[4] += point.r * point.x;
    sums[5] += point.t;
    sums[6] += g_new;
    sums[7] += touches && p_new + s * Kd <= 0 ? 1.f : 0.f;
    sums[8] += !closed && g_new + s * d <= 0 ? 1.f : 0.f;
    return point;
}

// Update and restriction in one pass. Of a coarse point a block misses what its left neighbour and
// the strip above add; they write that to `edges` (blocks along a row, coarse rows of all strips,
// each with one more, 3) and `below` (strips, 3, m), and add_edges adds it.
extern "C" __global__ void __launch_bounds__(THREADS) update_rows(
    float* __restrict__ g, float* __restrict__ p, const unsigned short* __restrict__ d,
    const float* __restrict__ Kd, float s, Index i0, Index i1, float* __restrict__ coarse, Index m,
    float* __restrict__ edges, float* __restrict__ below, double* partial)
{
    __shared__ float odd[2][3][THREADS + 1];
    Index c = (Index)blockIdx.x * THREADS + threadIdx.x;
    Index start = i0 + (Index)blockIdx.y * STRIP;
    Index end = min(start + STRIP, i1);
    Index n = 2 * m;
    Index plane = (m + 2) * m;
    bool in = c < m;
    bool last = in && (threadIdx.x == THREADS - 1 || c == m - 1);
    float sums[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
    float even_carry[3] = {0, 0, 0}, odd_carry[3] = {0, 0, 0};
    if (threadIdx.x == 0)
        for (int f = 0; f < 3; f++) odd[0][f][0] = odd[1][f][0] = 0;
    int row = 0;
    Index edge_rows = (Index)gridDim.y * (STRIP / 2 + 1);
    float* edge = edges + ((Index)blockIdx.x * edge_rows + blockIdx.y * (STRIP / 2 + 1)) * 3;
    for (Index i = start; i <= end; i += 2, row++) {
        float even_sum[3], odd_sum[3];
        for (int f = 0; f < 3; f++) { even_sum[f] = even_carry[f]; odd_sum[f] = odd_carry[f]; }
        if (in && i < end) {
            for (int k = 0; k < 2; k++) {
                Index at = (i + k) * n + 2 * c;
                Index at_rows = at - i0 * n;
                float2 G = *(float2*)(g + at);
                float2 P = *(float2*)(p + at);
                ushort2 D = *(const ushort2*)(d + at_rows);
                float2 X = *(const float2*)(Kd + at_rows);
                Point a = change_point(G.x, P.x, D.x, X.x, s, sums);
                Point b = change_point(G.y, P.y, D.y, X.y, s, sums);
                *(float2*)(g + at) = G;
                *(float2*)(p + at) = P;
                float even_point[3] = {a.r, a.t, a.x}, odd_point[3] = {b.r, b.t, b.x};
                float weight = k ? .5f : 1.f;
                for (int f = 0; f < 3; f++) {
                    even_sum[f] += weight * even_point[f];
                    odd_sum[f] += weight * odd_point[f];
                    if (k) { even_carry[f] = .5f * even_point[f]; odd_carry[f] = .5f * odd_point[f]; }
                }
            }
        }
        for (int f = 0; f < 3; f++) odd[row % 2][f][threadIdx.x + 1] = odd_sum[f];
        __syncthreads();
        if (in) {
            for (int f = 0; f < 3; f++) {
                float value = .25f * (even_sum[f] + .5f * (odd_sum[f] + odd[row % 2][f][threadIdx.x]));
                if (i < end) coarse[f * plane + (i / 2 + 1) * m + c] = value;
                else below[((Index)blockIdx.y * 3 + f) * m + c] = value;
                if (last) edge[row * 3 + f] = .125f * odd_sum[f];
            }
        }
    }
    for (int k = 0; k < 9; k++) sum_of_block(sums[k], partial, 10, k);
    sum_of_block(0.f, partial, 10, 9);
}

// Add what update_rows has left: first the left columns of all blocks, then the first rows of all
// strips. A thread has a coarse column of one strip; before (3, m) is what the pass before adds to
// the first row of this one, and becomes what this pass adds to the row after its last.
extern "C" __global__ void __launch_bounds__(THREADS) add_columns(
    Index i0, Index i1, float* coarse, Index m, const float* edges, float* below)
{
    Index strip = blockIdx.y;
    Index block = (Index)blockIdx.x * THREADS + threadIdx.x;
    Index blocks = (m + THREADS - 1) / THREADS;
    if (block >= blocks) return;
    Index start = i0 + strip * STRIP;
    Index rows = (min(start + STRIP, i1) - start) / 2;
    Index left = block > 0 ? block - 1 : blocks - 1;
    Index edge_rows = (Index)gridDim.y * (STRIP / 2 + 1);
    const float* edge = edges + (left * edge_rows + strip * (STRIP / 2 + 1)) * 3;
    Index c = block * THREADS;
    for (Index row = 0; row < rows; row++)
        for (int f = 0; f < 3; f++)
            coarse[f * (m + 2) * m + (start / 2 + 1 + row) * m + c] += edge[row * 3 + f];
    for (int f = 0; f < 3; f++) below[(strip * 3 + f) * m + c] += edge[rows * 3 + f];
}

extern "C" __global__ void __launch_bounds__(THREADS) add_rows(
    Index i0, Index i1, float* coarse, Index m, const float* below, float* before)
{
    Index strip = blockIdx.y;
    Index c = (Index)blockIdx.x * THREADS + threadIdx.x;
    if (c >= m) return;
    Index J = (i0 + strip * STRIP) / 2 + 1;
    for (int f = 0; f < 3; f++)
        coarse[f * (m + 2) * m + J * m + c] +=
            strip ? below[((strip - 1) * 3 + f) * m + c] : before[f * m + c];
}

extern "C" __global__ void __launch_bounds__(THREADS) multiply_block(
    float2* block, Index pitch, Index rows, Index columns, const float* q_0, const float* q_1,
    const float* weight_0, const float* weight_1, float factor, double* partial)
{
    Index j = (Index)blockIdx.x * THREADS + threadIdx.x;
    Index start = (Index)blockIdx.y * STRIP;
    Index end = min(start + STRIP, rows);
    float energy = 0;
    if (j < columns) {
        float square = q_1[j] * q_1[j];
        for (Index i = start; i < end; i++) {
            float scaled = factor * sqrtf(q_0[i] * q_0[i] + square);
            float2 number = block[i * pitch + j];
            energy += weight_0[i] * scaled * (number.x * number.x + number.y * number.y);
            number.x *= scaled;
            number.y *= scaled;
            block[i * pitch + j] = number;
        }
        energy *= weight_1[j];
    }
    sum_of_block(energy, partial, 1, 0);
}

// 32 x 8 threads
extern "C" __global__ void transpose_tiles(
    const float2* source, Index source_pitch, float2* target, Index target_pitch, Index rows,
    Index columns)
{
    __shared__ float2 tile[32][33];
    Index i0 = (Index)blockIdx.y * 32, j0 = (Index)blockIdx.x * 32;
    for (int y = threadIdx.y; y < 32; y += 8)
        if (i0 + y < rows && j0 + threadIdx.x < columns)
            tile[y][threadIdx.x] = source[(i0 + y) * source_pitch + j0 + threadIdx.x];
    __syncthreads();
    for (int y = threadIdx.y; y < 32; y += 8)
        if (i0 + threadIdx.x < rows && j0 + y < columns)
            target[(j0 + y) * target_pitch + i0 + threadIdx.x] = tile[threadIdx.x][y];
}
