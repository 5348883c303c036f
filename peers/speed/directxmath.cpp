// Jobs of `lobe bench` by DirectXSH, one thread.
//
//     directxmath JOB ORDER SECONDS < numbers > results
//
// Reads floats: directions for basis and basis-streamed; the rows of a rotation that multiplies columns, then functions, for rotation
// and rotation-one; functions and as many others for product-one; the texels of the faces +x, -x, +y, -y, +z, -z of a
// cube for project-cube. Writes the coefficients, one function after the other, and on stderr the nanoseconds for one
// item. DirectXMath's order counts bands as ours does, and its signs are ours.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "timing.h"

#include <DirectXMath.h>
#include <DirectXSH.h>

using namespace DirectX;

namespace {

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

// The library projects cube maps of Direct3D alone. This is a loop over texels around its own functions: the middle
// of each, and sums in single precision, as there.
double project_cube(size_t order, double seconds, const Floats &texels, Floats &out) {
    const size_t width = order * order, count = texels.size() / 3, size = std::lround(std::sqrt(count / 6.0));
    out.resize(3 * width);
    const double ns = nanoseconds(seconds, [&] {
        std::fill(out.begin(), out.end(), 0.0f);
        float sum_of_weights = 0;
        const float *texel = texels.data();
        for (size_t face = 0; face < 6; ++face) {
            for (size_t y = 0; y < size; ++y) {
                const float v = (2 * y + 1.0f) / size - 1;
                for (size_t x = 0; x < size; ++x, texel += 3) {
                    const float u = (2 * x + 1.0f) / size - 1, square = 1 + u * u + v * v;
                    const float side = face % 2 == 0 ? 1.0f : -1.0f;
                    const XMVECTOR across = face / 2 == 0   ? XMVectorSet(side, -v, -side * u, 0)
                                            : face / 2 == 1 ? XMVectorSet(u, side, side * v, 0)
                                                            : XMVectorSet(side * u, -v, side, 0);
                    const float weight = 4 / (square * std::sqrt(square));
                    float basis[XM_SH_MAXORDER * XM_SH_MAXORDER], scaled[XM_SH_MAXORDER * XM_SH_MAXORDER];
                    XMSHEvalDirection(basis, order, XMVector3Normalize(across));
                    for (size_t c = 0; c < 3; ++c) {
                        XMSHScale(scaled, order, basis, texel[c] * weight);
                        XMSHAdd(&out[c * width], order, &out[c * width], scaled);
                    }
                    sum_of_weights += weight;
                }
            }
        }
        const float scale = 4 * XM_PI / sum_of_weights;
        for (size_t c = 0; c < 3; ++c) {
            XMSHScale(&out[c * width], order, &out[c * width], scale);
        }
    });
    return ns / static_cast<double>(count);
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
    } else if (job == "project-cube") {
        ns = project_cube(order, seconds, numbers, out);
    } else {
        std::fprintf(stderr, "unknown job %s\n", job.c_str());
        return 2;
    }
    std::fwrite(out.data(), sizeof(float), out.size(), stdout);
    std::fprintf(stderr, "%.6f\n", ns);
    return 0;
}
