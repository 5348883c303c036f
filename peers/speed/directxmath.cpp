// Jobs of `lobe bench` by DirectXSH, one thread.
//
//     directxmath JOB ORDER SECONDS < numbers > results
//
// Reads floats: directions for basis and basis-streamed; the rows of a rotation that multiplies columns, then functions, for rotation
// and rotation-one; functions and as many others for product-one. Writes the coefficients, one function after the other, and on
// stderr the nanoseconds for one. DirectXMath's order counts bands as ours does, and its signs are ours.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include <DirectXMath.h>
#include <DirectXSH.h>

using namespace DirectX;

namespace {

using Floats = std::vector<float>;
using Clock = std::chrono::steady_clock;

// A sample takes this long at least, as in `lobe bench`.
constexpr double kSampleNs = 1e6;
constexpr int kLeastSamples = 3;

Floats read_all() {
    Floats numbers;
    float part[4096];
    for (size_t count; (count = std::fread(part, sizeof(float), 4096, stdin)) > 0;) {
        numbers.insert(numbers.end(), part, part + count);
    }
    return numbers;
}

template <class Work>
double time_ns(Work &&work) {
    const auto begun = Clock::now();
    work();
    return std::chrono::duration<double, std::nano>(Clock::now() - begun).count();
}

// The least of many samples: everything that disturbs makes it slower.
template <class Work>
double nanoseconds(double seconds, Work &&work) {
    work();
    const int repeats = std::max(1, static_cast<int>(kSampleNs / std::max(1.0, time_ns(work))));
    double least = std::numeric_limits<double>::infinity(), spent = 0;
    for (int samples = 0; samples < kLeastSamples || spent < seconds * 1e9; ++samples) {
        const double sample = time_ns([&] {
            for (int k = 0; k < repeats; ++k) {
                work();
                // The results may be read by anyone: no run can be left out.
                asm volatile("" ::: "memory");
            }
        });
        least = std::min(least, sample / repeats);
        spent += sample;
    }
    return least;
}

// Vectors of rows are multiplied from the left there: the transposed matrix.
XMMATRIX matrix_of(const float *r) {
    return XMMatrixSet(r[0], r[3], r[6], 0, r[1], r[4], r[7], 0, r[2], r[5], r[8], 0, 0, 0, 0, 1);
}

float *multiply(float *out, size_t order, const float *f, const float *g) {
    switch (order) {
    case 2: return XMSHMultiply2(out, f, g);
    case 3: return XMSHMultiply3(out, f, g);
    case 4: return XMSHMultiply4(out, f, g);
    case 5: return XMSHMultiply5(out, f, g);
    default: return XMSHMultiply6(out, f, g);
    }
}

double basis(size_t order, double seconds, const Floats &directions, Floats &out) {
    const size_t count = directions.size() / 3, width = order * order;
    out.resize(count * width);
    return nanoseconds(seconds, [&] {
        for (size_t k = 0; k < count; ++k) {
            const float *d = &directions[3 * k];
            XMSHEvalDirection(&out[k * width], order, XMVectorSet(d[0], d[1], d[2], 0));
        }
    }) / static_cast<double>(count);
}

double rotation(size_t order, double seconds, const Floats &numbers, Floats &out) {
    const size_t width = order * order, count = (numbers.size() - 9) / width;
    const float *f = numbers.data() + 9;
    out.resize(count * width);
    return nanoseconds(seconds, [&] {
        const XMMATRIX matrix = matrix_of(numbers.data());
        for (size_t k = 0; k < count; ++k) {
            XMSHRotate(&out[k * width], order, matrix, f + k * width);
        }
    }) / static_cast<double>(count);
}

double product(size_t order, double seconds, const Floats &numbers, Floats &out) {
    const size_t width = order * order, count = numbers.size() / (2 * width);
    const float *f = numbers.data(), *g = f + count * width;
    out.resize(count * width);
    return nanoseconds(seconds, [&] {
        for (size_t k = 0; k < count; ++k) {
            multiply(&out[k * width], order, f + k * width, g + k * width);
        }
    }) / static_cast<double>(count);
}

}  // namespace

int main(int count, char **arguments) {
    if (count != 4) {
        std::fprintf(stderr, "expected JOB ORDER SECONDS\n");
        return 2;
    }
    const std::string job = arguments[1];
    const size_t order = std::strtoul(arguments[2], nullptr, 10);
    const double seconds = std::strtod(arguments[3], nullptr);
    if (order < XM_SH_MINORDER || order > XM_SH_MAXORDER) {
        std::fprintf(stderr, "order %zu, expected 2 to 6\n", order);
        return 2;
    }
    const Floats numbers = read_all();
    Floats out;
    double ns = 0;
    if (job == "basis" || job == "basis-streamed") {
        ns = basis(order, seconds, numbers, out);
    } else if (job == "rotation" || job == "rotation-one") {
        ns = rotation(order, seconds, numbers, out);
    } else if (job == "product-one") {
        ns = product(order, seconds, numbers, out);
    } else {
        std::fprintf(stderr, "unknown job %s\n", job.c_str());
        return 2;
    }
    std::fwrite(out.data(), sizeof(float), out.size(), stdout);
    std::fprintf(stderr, "%.6f\n", ns);
    return 0;
}
