// Numbers in and out, and the clock, of the peers in C++.

#pragma once

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <vector>

using Floats = std::vector<float>;
using Clock = std::chrono::steady_clock;

// A sample takes this long at least, as in `lobe bench`.
constexpr double kSampleNs = 1e6;
constexpr int kLeastSamples = 3;

inline Floats read_all() {
    Floats numbers;
    float part[4096];
    for (size_t count; (count = std::fread(part, sizeof(float), 4096, stdin)) > 0;) {
        numbers.insert(numbers.end(), part, part + count);
    }
    return numbers;
}

template <class Work>
inline double time_ns(Work &&work) {
    const auto begun = Clock::now();
    work();
    return std::chrono::duration<double, std::nano>(Clock::now() - begun).count();
}

// The least of many samples: everything that disturbs makes it slower.
template <class Work>
inline double nanoseconds(double seconds, Work &&work) {
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
