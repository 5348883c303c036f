// Jobs of `lobe bench` by libfilament_ibl.
//
//     filament JOB ORDER SECONDS < numbers > results
//
// Reads floats: the texels of the faces +x, -x, +y, -y, +z, -z of a cube for project-cube; the coefficients of an
// irradiance, color within coefficient, for irradiance; those of probes for dering. Writes coefficients, color within
// coefficient, or texels, and on stderr the nanoseconds for one item.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>

#include <ibl/Cubemap.h>
#include <ibl/CubemapSH.h>
#include <ibl/CubemapUtils.h>

#include "timing.h"

// Debian's package lacks this header. The functions are those of the library; the place is larger than any version takes.
namespace utils {
class JobSystem {
public:
    explicit JobSystem(size_t threads = 0, size_t adoptable = 1) noexcept;
    ~JobSystem();
    void adopt();
    void emancipate();

private:
    alignas(64) char place_[1 << 20];
};
}  // namespace utils

using filament::ibl::Cubemap;
using filament::ibl::CubemapSH;
using filament::ibl::CubemapUtils;
using filament::ibl::Image;
using filament::math::float3;

namespace {

using Functions = std::unique_ptr<float3[]>;

// Texels along a side of the cube that irradiance is written to.
constexpr size_t kSide = 64;

double project_cube(utils::JobSystem &jobs, size_t order, double seconds, const Floats &texels, Floats &out) {
    const size_t side = std::lround(std::sqrt(texels.size() / 18.0));
    Image image;
    Cubemap cube = CubemapUtils::create(image, side);
    const float *from = texels.data();
    for (size_t face = 0; face < 6; ++face) {
        for (size_t y = 0; y < side; ++y, from += 3 * side) {
            std::memcpy(cube.getImageForFace(Cubemap::Face(face)).getPixelRef(0, y), from, 3 * side * sizeof(float));
        }
    }
    Functions found;
    const double ns = nanoseconds(seconds, [&] { found = CubemapSH::computeSH(jobs, cube, order, false); });
    const float *numbers = reinterpret_cast<const float *>(found.get());
    out.assign(numbers, numbers + 3 * order * order);
    return ns / static_cast<double>(6 * side * side);
}

double irradiance(utils::JobSystem &jobs, double seconds, const Floats &coefficients, Floats &out) {
    Functions sh(new float3[9]);
    std::memcpy(sh.get(), coefficients.data(), 27 * sizeof(float));
    CubemapSH::preprocessSHForShader(sh);
    Image image;
    Cubemap cube = CubemapUtils::create(image, kSide);
    const double ns = nanoseconds(seconds, [&] { CubemapSH::renderPreScaledSH3Bands(jobs, cube, sh); });
    for (size_t face = 0; face < 6; ++face) {
        for (size_t y = 0; y < kSide; ++y) {
            const auto *row = static_cast<const float *>(cube.getImageForFace(Cubemap::Face(face)).getPixelRef(0, y));
            out.insert(out.end(), row, row + 3 * kSide);
        }
    }
    return ns / static_cast<double>(6 * kSide * kSide);
}

double dering(double seconds, const Floats &probes, Floats &out) {
    const size_t count = probes.size() / 27;
    Functions sh(new float3[9]);
    out.resize(probes.size());
    return nanoseconds(seconds, [&] {
        for (size_t k = 0; k < count; ++k) {
            std::memcpy(sh.get(), &probes[27 * k], 27 * sizeof(float));
            // No cutoff: it is looked for.
            CubemapSH::windowSH(sh, 3, 0);
            std::memcpy(&out[27 * k], sh.get(), 27 * sizeof(float));
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
    const Floats numbers = read_all();
    const auto jobs = std::make_unique<utils::JobSystem>(1, 1);
    jobs->adopt();
    Floats out;
    double ns = 0;
    if (job == "project-cube") {
        ns = project_cube(*jobs, order, seconds, numbers, out);
    } else if (job == "irradiance" && order == 3) {
        ns = irradiance(*jobs, seconds, numbers, out);
    } else if (job == "dering" && order == 3) {
        ns = dering(seconds, numbers, out);
    } else {
        std::fprintf(stderr, "unknown job %s of order %zu\n", job.c_str(), order);
        return 2;
    }
    jobs->emancipate();
    std::fwrite(out.data(), sizeof(float), out.size(), stdout);
    std::fprintf(stderr, "%.6f\n", ns);
    return 0;
}
