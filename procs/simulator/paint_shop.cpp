// SPDX-License-Identifier: Apache-2.0
#include "procs/simulator/paint_shop.hpp"

#include <utility>

namespace cairn {

PaintShop::PaintShop(FramePainter painter, Place place) : painter_{std::move(painter)} {
  if (place == Place::kOwnThread)
    thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
}

PaintShop::~PaintShop() = default;

bool PaintShop::has_room() const {
  const std::lock_guard lock{mutex_};
  return orders_.size() < kRoom;
}

void PaintShop::order(Capture capture) {
  if (!thread_.joinable()) {
    painted_.push_back(painter_.paint(capture));
    return;
  }
  {
    const std::lock_guard lock{mutex_};
    orders_.push_back(std::move(capture));
  }
  ordered_.notify_one();
}

std::vector<Result<stereo_frame_t>> PaintShop::take() {
  const std::lock_guard lock{mutex_};
  return std::exchange(painted_, {});
}

void PaintShop::work(const std::stop_token& stop) {
  while (true) {
    Capture capture;
    {
      std::unique_lock lock{mutex_};
      if (!ordered_.wait(lock, stop, [this] { return !orders_.empty(); })) return;
      capture = std::move(orders_.front());
      orders_.pop_front();
    }
    auto frame = painter_.paint(capture);
    const std::lock_guard lock{mutex_};
    painted_.push_back(std::move(frame));
  }
}

}  // namespace cairn
