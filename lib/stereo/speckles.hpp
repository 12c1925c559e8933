// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace cairn::stereo {

/// Sets to `no_answer` what is on an island of at most `max_size_px` pixels: pixels above
/// `no_answer` belong together where they are neighbours in a row or a column and differ by at most
/// `max_step_16ths`. Runs along rows, joined across rows by union-find (Rosenfeld and Pfaltz 1966).
void remove_speckles(cv::Mat_<std::int16_t>& disparity_16ths, std::int16_t no_answer,
                     int max_size_px, int max_step_16ths);

}  // namespace cairn::stereo
