// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/stereo_frame_t.hpp>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "core/result.hpp"
#include "procs/simulator/frame_painter.hpp"

namespace cairn {

/// Paints captures one after the other: at once, or on a thread of its own, so that whoever orders
/// a picture need not wait for it. The pictures are the same, and come in the captures' order.
class PaintShop {
 public:
  enum class Place { kHere, kOwnThread };
  /// So many captures may wait for the thread.
  static constexpr std::size_t kRoom = 3;

  PaintShop(FramePainter painter, Place place);
  ~PaintShop();
  PaintShop(const PaintShop&) = delete;
  PaintShop& operator=(const PaintShop&) = delete;

  [[nodiscard]] bool has_room() const;
  /// There must be room.
  void order(Capture capture);
  /// What has been painted since the last call.
  [[nodiscard]] std::vector<Result<stereo_frame_t>> take();

 private:
  void work(const std::stop_token& stop);

  FramePainter painter_;
  mutable std::mutex mutex_;
  std::condition_variable_any ordered_;
  std::deque<Capture> orders_;
  std::vector<Result<stereo_frame_t>> painted_;
  std::jthread thread_;  ///< ends before what it uses
};

}  // namespace cairn
