// SPDX-License-Identifier: Apache-2.0
#include "stereo/path_aggregation.hpp"

#include <algorithm>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <thread>
#include <vector>

#include "stereo/census.hpp"

// AVX-512 adds nothing to lanes capped at 32 bytes. The emulated target is plain C++ that tests
// compare with.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_RVV)
#define HWY_COMPILE_ALL_ATTAINABLE
#define HWY_BROKEN_EMU128 0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/path_aggregation.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#ifndef CAIRN_STEREO_SWEEP
#define CAIRN_STEREO_SWEEP
namespace cairn::stereo {

constexpr int kMargin_px = 32;  ///< of slack on either side of a row, for whole vectors
constexpr int kRows = 2 * kCensusReachY_px + 1;
constexpr int kColumns = 2 * kCensusReachX_px + 1;

/// The disparities of a pixel lie spread over `vectors` registers: d = vectors * lane + register,
/// so that d + 1 and d - 1 of a whole register are its neighbours, and only the first and the last
/// need a shift by one lane.
struct Spread {
  int vectors = 0;
  int lanes = 0;

  [[nodiscard]] int place(int d) const { return d % vectors * lanes + d / vectors; }
  [[nodiscard]] int size() const { return vectors * lanes; }
};

/// The right image's rows stored so that a load of `lanes` bytes takes every vectors-th pixel from
/// right to left: one sub-row for each column modulo `vectors`.
struct RightLayout {
  int vectors = 1;
  int pad_px = 0;  ///< columns before the image
  int last = 0;    ///< the last index within a sub-row
  int stride = 0;  ///< of sub-rows

  RightLayout(const SearchRange& range, int cols, const Spread& spread)
      : vectors{spread.vectors},
        pad_px{range.min_px + spread.size() + kCensusReachX_px + spread.vectors},
        last{(pad_px + cols + kCensusReachX_px) / spread.vectors + 1},
        stride{last + 1 + 2 * kMargin_px} {}

  [[nodiscard]] int place(int x) const {
    const int column = x + pad_px;
    return column % vectors * stride + kMargin_px + last - column / vectors;
  }
  [[nodiscard]] int size() const { return vectors * stride; }
};

struct SweepInput {
  cv::Mat left;   ///< widened by kMargin_px on either side
  cv::Mat right;  ///< one row of RightLayout per row
  int cols = 0;
  SearchRange range;
  RightLayout layout;
  Penalties penalties;
  std::vector<int> right_place;             ///< of column x at x + layout.pad_px
  std::vector<std::uint8_t> outside;        ///< 255 at the places of no disparity
  std::array<std::uint8_t, 256> by_more{};  ///< the penalty of a jump, by the change of grey

  [[nodiscard]] int rows() const { return left.rows; }
};

/// From row `first` by `step` rows, `count` rows.
struct Band {
  int first = 0;
  int step = 1;
  int count = 0;
};

struct CostTables {
  alignas(16) NibbleCosts census = census_costs();
  alignas(16) NibbleCosts gradient = gradient_costs();
};

}  // namespace cairn::stereo
#endif

HWY_BEFORE_NAMESPACE();
namespace cairn::stereo {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Bytes = hn::CappedTag<std::uint8_t, 32>;
using Vec = hn::Vec<Bytes>;
constexpr Bytes kBytes;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(Bytes()));

/// Lane i takes lane i - 1; lane 0 takes 0.
HWY_INLINE Vec shift_up(Vec v) {
  const Vec zero = hn::Zero(kBytes);
#if HWY_TARGET == HWY_AVX2
  return hn::CombineShiftRightBytes<15>(kBytes, v, hn::ConcatLowerLower(kBytes, v, zero));
#else
  return hn::CombineShiftRightBytes<15>(kBytes, v, zero);
#endif
}

/// Lane i takes lane i + 1; the last takes 0.
HWY_INLINE Vec shift_down(Vec v) {
  const Vec zero = hn::Zero(kBytes);
#if HWY_TARGET == HWY_AVX2
  return hn::CombineShiftRightBytes<1>(kBytes, hn::ConcatUpperUpper(kBytes, zero, v), v);
#else
  return hn::CombineShiftRightBytes<1>(kBytes, zero, v);
#endif
}

struct Least {
  HWY_INLINE Vec operator()(Vec a, Vec b) const { return hn::Min(a, b); }
};
struct Most {
  HWY_INLINE Vec operator()(Vec a, Vec b) const { return hn::Max(a, b); }
};

/// Every lane becomes the least (most) of all lanes.
template <class Pick>
HWY_INLINE Vec over_lanes(Vec v, Pick pick) {
  const hn::Repartition<std::uint32_t, Bytes> words;
  alignas(16) static constexpr std::uint8_t kByTwo[16] = {2,  3,  0, 1, 6,  7,  4,  5,
                                                          10, 11, 8, 9, 14, 15, 12, 13};
  alignas(16) static constexpr std::uint8_t kByOne[16] = {1, 0, 3,  2,  5,  4,  7,  6,
                                                          9, 8, 11, 10, 13, 12, 15, 14};
#if HWY_TARGET == HWY_AVX2
  v = pick(v, hn::SwapAdjacentBlocks(v));
#endif
  v = pick(v, hn::BitCast(kBytes, hn::Shuffle1032(hn::BitCast(words, v))));
  v = pick(v, hn::BitCast(kBytes, hn::Shuffle2301(hn::BitCast(words, v))));
  v = pick(v, hn::TableLookupBytes(v, hn::LoadDup128(kBytes, kByTwo)));
  return pick(v, hn::TableLookupBytes(v, hn::LoadDup128(kBytes, kByOne)));
}

template <int K, class Pick>
HWY_INLINE Vec over_all(const Vec (&v)[K], Pick pick) {
  Vec picked = v[0];
  for (int k = 1; k < K; ++k) picked = pick(picked, v[k]);
  return over_lanes(picked, pick);
}

/// One step of a path: `path` is V of the pixel before, and becomes V of this one.
template <int K>
HWY_INLINE void step(const Vec (&cost)[K], Vec by_one, Vec by_more_next, Vec base, Vec (&path)[K]) {
  Vec lagging[K];
  const Vec below_first = shift_up(path[K - 1]);
  const Vec above_last = shift_down(path[0]);
  for (int k = 0; k < K; ++k) {
    const Vec below = k > 0 ? path[k - 1] : below_first;
    const Vec above = k < K - 1 ? path[k + 1] : above_last;
    const Vec stepped = hn::SaturatedSub(hn::Max(below, above), by_one);
    lagging[k] = hn::Sub(hn::SaturatedAdd(cost[k], base), hn::Max(path[k], stepped));
  }
  const Vec top = hn::Add(over_all<K>(lagging, Least()), by_more_next);
  for (int k = 0; k < K; ++k) path[k] = hn::SaturatedSub(top, lagging[k]);
}

/// The descriptors of `count` pixels (rounded up to whole vectors): rows[dy + reach] + shift[dx +
/// reach] is where the neighbour (dx, dy) of the first one is.
void describe(const std::uint8_t* const (&rows)[kRows], const int (&shift)[kColumns], int count,
              std::uint8_t* const (&nibbles)[kDescriptorNibbles]) {
  const auto at = [&](Offset o, int i) HWY_ATTR {
    return hn::LoadU(kBytes, rows[o.dy + kCensusReachY_px] + shift[o.dx + kCensusReachX_px] + i);
  };
  const auto column = [&](int dx, int i) HWY_ATTR {
    return hn::AverageRound(hn::AverageRound(at({dx, -1}, i), at({dx, 1}, i)), at({dx, 0}, i));
  };
  const Vec zero = hn::Zero(kBytes);
  const Vec one = hn::Set(kBytes, 1);
  for (int i = 0; i < count; i += kLanes) {
    const Vec middle = at({0, 0}, i);
    for (int nibble = 0; nibble < 3; ++nibble) {
      Vec bits = zero;
      for (int bit = 0; bit < 4; ++bit) {
        const Vec neighbour = at(kCensusNeighbours[static_cast<std::size_t>(4 * nibble + bit)], i);
        const Vec brighter = hn::Min(hn::SaturatedSub(neighbour, middle), one);
        bits = hn::Add(hn::Add(bits, bits), brighter);
      }
      hn::StoreU(bits, kBytes, nibbles[nibble] + i);
    }
    const Vec before = column(-1, i);
    const Vec after = column(1, i);
    const Vec rise = hn::SaturatedSub(after, before);
    const Vec fall = hn::SaturatedSub(before, after);
    Vec level = hn::Set(kBytes, 8);
    for (const std::uint8_t reach : kGradientSteps_grey) {
      const Vec below = hn::Set(kBytes, static_cast<std::uint8_t>(reach - 1));
      level = hn::Add(level, hn::Min(hn::SaturatedSub(rise, below), one));
      level = hn::Sub(level, hn::Min(hn::SaturatedSub(fall, below), one));
    }
    hn::StoreU(level, kBytes, nibbles[3] + i);
  }
}

/// Works a band row by row; owns the buffers of one thread.
template <int K>
class Sweep {
 public:
  static constexpr int kDisparities = K * kLanes;

  explicit Sweep(const SweepInput& in)
      : in_{in},
        spread_{K, kLanes},
        left_stride_{in.cols + 2 * kMargin_px},
        left_(static_cast<std::size_t>(kDescriptorNibbles * left_stride_)),
        right_(static_cast<std::size_t>(kDescriptorNibbles * in.layout.size())),
        cost_(row_size()),
        from_left_(row_size()),
        across_(row_size()),
        jump_along_(static_cast<std::size_t>(in.cols) + 1),
        jump_across_(static_cast<std::size_t>(in.cols)) {
    for (int d = -1; d <= kDisparities; ++d) {
      const int inside = std::clamp(d, 0, kDisparities - 1);
      place_[static_cast<std::size_t>(d + 1)] =
          d == inside ? spread_.place(d) : kDisparities;  // where support is always 0
    }
  }

  void run(const Band& band, Winners& winners) {
    for (int i = 0; i < band.count; ++i) {
      const int row = band.first + i * band.step;
      describe_row(row);
      find_jumps(row, std::clamp(row + band.step, 0, in_.rows() - 1));
      match_from_left();
      match_from_right(row, winners);
    }
  }

 private:
  [[nodiscard]] std::size_t row_size() const {
    return static_cast<std::size_t>(in_.cols) * kDisparities;
  }

  void describe_row(int row) {
    const std::uint8_t* left_rows[kRows];
    const std::uint8_t* right_rows[kRows];
    for (int i = 0; i < kRows; ++i) {
      const int at = std::clamp(row + i - kCensusReachY_px, 0, in_.rows() - 1);
      left_rows[i] = in_.left.ptr(at) + kMargin_px;
      right_rows[i] = in_.right.ptr(at) + kMargin_px;
    }
    int shift[kColumns];
    for (int i = 0; i < kColumns; ++i) shift[i] = i - kCensusReachX_px;
    std::uint8_t* nibbles[kDescriptorNibbles];
    for (int n = 0; n < kDescriptorNibbles; ++n) nibbles[n] = left_.data() + n * left_stride_;
    describe(left_rows, shift, in_.cols, nibbles);

    for (int phase = 0; phase < K; ++phase) {
      for (int i = 0; i < kColumns; ++i) {
        const int column = phase + i - kCensusReachX_px + 8 * K;  // not below 0
        shift[i] = column % K * in_.layout.stride - (column / K - 8);
      }
      for (int n = 0; n < kDescriptorNibbles; ++n) {
        nibbles[n] = right_.data() + n * in_.layout.size() + phase * in_.layout.stride + kMargin_px;
      }
      describe(right_rows, shift, in_.layout.last + 1, nibbles);
    }
  }

  /// The penalty of a jump between column x - 1 and x, and between this row and the next.
  void find_jumps(int row, int next_row) {
    const std::uint8_t* here = in_.left.ptr(row) + kMargin_px;
    const std::uint8_t* next = in_.left.ptr(next_row) + kMargin_px;
    for (int x = 0; x < in_.cols; ++x) {
      jump_along_[static_cast<std::size_t>(x)] =
          in_.by_more[static_cast<std::size_t>(std::abs(here[x] - here[x - 1]))];
      jump_across_[static_cast<std::size_t>(x)] =
          in_.by_more[static_cast<std::size_t>(std::abs(here[x] - next[x]))];
    }
    jump_along_[static_cast<std::size_t>(in_.cols)] = in_.by_more[0];
  }

  HWY_INLINE void load(const std::uint8_t* from, Vec (&v)[K]) const {
    for (int k = 0; k < K; ++k) v[k] = hn::LoadU(kBytes, from + k * kLanes);
  }
  HWY_INLINE void store(const Vec (&v)[K], std::uint8_t* to) const {
    for (int k = 0; k < K; ++k) hn::StoreU(v[k], kBytes, to + k * kLanes);
  }
  HWY_INLINE Vec base() const {
    return hn::Set(kBytes, static_cast<std::uint8_t>(in_.penalties.by_more_at_most));
  }

  /// The costs of a row, and the path that comes from the left.
  void match_from_left() {
    const Vec by_one = hn::Set(kBytes, static_cast<std::uint8_t>(in_.penalties.by_one_along_row));
    const Vec base_v = base();
    Vec path[K];
    Vec outside[K];
    for (int k = 0; k < K; ++k) path[k] = hn::Zero(kBytes);
    load(in_.outside.data(), outside);
    const int* place = in_.right_place.data() + in_.layout.pad_px - in_.range.min_px;
    const std::uint8_t* right = right_.data();
    const std::size_t plane = static_cast<std::size_t>(in_.layout.size());
    for (int x = 0; x < in_.cols; ++x) {
      const std::uint8_t* left = left_.data() + x;
      const Vec t0 = hn::LoadDup128(kBytes, tables_.census[left[0]].data());
      const Vec t1 = hn::LoadDup128(kBytes, tables_.census[left[left_stride_]].data());
      const Vec t2 = hn::LoadDup128(kBytes, tables_.census[left[2 * left_stride_]].data());
      const Vec t3 = hn::LoadDup128(kBytes, tables_.gradient[left[3 * left_stride_]].data());
      Vec cost[K];
      for (int k = 0; k < K; ++k) {
        const std::uint8_t* there = right + place[x - k];
        const Vec c01 = hn::Add(hn::TableLookupBytes(t0, hn::LoadU(kBytes, there)),
                                hn::TableLookupBytes(t1, hn::LoadU(kBytes, there + plane)));
        const Vec c23 = hn::Add(hn::TableLookupBytes(t2, hn::LoadU(kBytes, there + 2 * plane)),
                                hn::TableLookupBytes(t3, hn::LoadU(kBytes, there + 3 * plane)));
        cost[k] = hn::Or(hn::Add(c01, c23), outside[k]);
      }
      const Vec by_more = hn::Set(kBytes, jump_along_[static_cast<std::size_t>(x) + 1]);
      step<K>(cost, by_one, by_more, base_v, path);
      store(cost, cost_.data() + static_cast<std::size_t>(x) * kDisparities);
      store(path, from_left_.data() + static_cast<std::size_t>(x) * kDisparities);
    }
  }

  /// The paths from the right and from the row before, the sum of all three, and who wins.
  void match_from_right(int row, Winners& winners) {
    const Vec along = hn::Set(kBytes, static_cast<std::uint8_t>(in_.penalties.by_one_along_row));
    const Vec across = hn::Set(kBytes, static_cast<std::uint8_t>(in_.penalties.by_one_across_rows));
    const Vec base_v = base();
    const Vec one = hn::Set(kBytes, 1);
    const Vec two = hn::Set(kBytes, 2);
    Vec path[K];
    Vec seen[K];  // from the right image: the best support yet of the pixel at this disparity
    Vec index[K];
    for (int k = 0; k < K; ++k) {
      path[k] = hn::Zero(kBytes);
      seen[k] = hn::Zero(kBytes);
      index[k] = hn::LoadU(kBytes, index_of_place_.data() + k * kLanes);
    }
    alignas(32) std::uint8_t scratch[kDisparities + 32];
    scratch[kDisparities] = 0;
    for (int x = in_.cols - 1; x >= 0; --x) {
      const std::size_t column = static_cast<std::size_t>(x);
      const std::size_t at = column * kDisparities;
      Vec cost[K];
      Vec vertical[K];
      Vec support[K];
      load(cost_.data() + at, cost);
      load(across_.data() + at, vertical);
      load(from_left_.data() + at, support);
      step<K>(cost, along, hn::Set(kBytes, jump_along_[column]), base_v, path);
      step<K>(cost, across, hn::Set(kBytes, jump_across_[column]), base_v, vertical);
      store(vertical, across_.data() + at);
      for (int k = 0; k < K; ++k) {
        support[k] = hn::SaturatedAdd(support[k], hn::SaturatedAdd(path[k], vertical[k]));
      }
      store(support, scratch);

      const Vec most = over_all<K>(support, Most());
      Vec candidates = hn::Set(kBytes, 255);
      for (int k = 0; k < K; ++k) {
        candidates = hn::Min(
            candidates, hn::IfThenElse(hn::Eq(support[k], most), index[k], hn::Set(kBytes, 255)));
      }
      const Vec best = over_lanes(candidates, Least());
      const Vec before_best = hn::Sub(best, one);
      Vec others = hn::Zero(kBytes);
      for (int k = 0; k < K; ++k) {
        const Vec distance = hn::Sub(index[k], before_best);  // 0, 1, 2: too near
        others = hn::Max(others,
                         hn::IfThenZeroElse(hn::Eq(hn::Min(distance, two), distance), support[k]));
      }
      others = over_lanes(others, Most());

      const Vec first_seen = seen[0];
      for (int k = 0; k < K - 1; ++k) seen[k] = hn::Max(seen[k + 1], support[k]);
      seen[K - 1] = hn::Max(shift_down(first_seen), support[K - 1]);

      const std::size_t winner = hn::GetLane(best);
      winners.index(row, x) = static_cast<std::uint8_t>(winner);
      winners.support(row, x) = hn::GetLane(most);
      winners.below(row, x) = scratch[place_[winner]];
      winners.above(row, x) = scratch[place_[winner + 2]];
      winners.runner_up(row, x) = hn::GetLane(others);
      winners.right_support(row, x) = hn::GetLane(seen[0]);
    }
  }

  static constexpr std::array<std::uint8_t, kDisparities> index_of_place() {
    std::array<std::uint8_t, kDisparities> index{};
    for (int place = 0; place < kDisparities; ++place) {
      index[static_cast<std::size_t>(place)] =
          static_cast<std::uint8_t>(place % kLanes * K + place / kLanes);
    }
    return index;
  }

  const SweepInput& in_;
  Spread spread_;
  int left_stride_;
  CostTables tables_;
  std::array<int, kDisparities + 2> place_{};
  std::array<std::uint8_t, kDisparities> index_of_place_ = index_of_place();
  std::vector<std::uint8_t> left_;   ///< descriptors, one plane per nibble
  std::vector<std::uint8_t> right_;  ///< likewise, in RightLayout
  std::vector<std::uint8_t> cost_;   ///< of the row, per pixel K vectors
  std::vector<std::uint8_t> from_left_;
  std::vector<std::uint8_t> across_;  ///< V of the row before, then of this one
  std::vector<std::uint8_t> jump_along_;
  std::vector<std::uint8_t> jump_across_;
};

int lanes() { return kLanes; }

template <int K>
void sweep_with(const SweepInput& in, const Band& band, Winners& winners) {
  if constexpr (K * kLanes <= 256 && K * kLanes % 32 == 0) {
    if (in.layout.vectors == K) return Sweep<K>(in).run(band, winners);
  }
  if constexpr (K * kLanes < 256) sweep_with<K + 1>(in, band, winners);
}

void sweep(const SweepInput& in, const Band& band, Winners& winners) {
  sweep_with<1>(in, band, winners);
}

}  // namespace HWY_NAMESPACE
}  // namespace cairn::stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cairn::stereo {
namespace {

HWY_EXPORT(lanes);
HWY_EXPORT(sweep);

SweepInput prepare(const cv::Mat& left, const cv::Mat& right, const SearchRange& range,
                   const Penalties& penalties) {
  const int count = range.end_px - range.min_px;
  const int lanes = HWY_DYNAMIC_DISPATCH(lanes)();
  const Spread spread{(count + 31) / 32 * 32 / lanes, lanes};
  SweepInput in{.left = {},
                .right = {},
                .cols = left.cols,
                .range = range,
                .layout = RightLayout(range, left.cols, spread),
                .penalties = penalties,
                .right_place = {},
                .outside = {}};
  cv::copyMakeBorder(left, in.left, 0, 0, kMargin_px, 2 * kMargin_px,
                     cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
  for (int x = -in.layout.pad_px; x < left.cols + kCensusReachX_px; ++x) {
    in.right_place.push_back(in.layout.place(x));
  }
  in.right = cv::Mat::zeros(right.rows, in.layout.size() + kMargin_px, CV_8UC1);
  for (int row = 0; row < right.rows; ++row) {
    const std::uint8_t* from = right.ptr(row);
    std::uint8_t* to = in.right.ptr(row);
    for (int i = 0; i < static_cast<int>(in.right_place.size()); ++i) {
      to[in.right_place[static_cast<std::size_t>(i)]] =
          from[std::clamp(i - in.layout.pad_px, 0, right.cols - 1)];
    }
  }
  in.outside.assign(static_cast<std::size_t>(spread.size()), 0);
  for (int d = count; d < spread.size(); ++d) {
    in.outside[static_cast<std::size_t>(spread.place(d))] = 255;
  }
  for (int change = 0; change < 256; ++change) {
    in.by_more[static_cast<std::size_t>(change)] = static_cast<std::uint8_t>(
        std::max(penalties.by_more_at_least,
                 penalties.by_more_at_most - change * penalties.by_more_per_grey));
  }
  return in;
}

}  // namespace

void Winners::create(cv::Size size) {
  for (cv::Mat_<std::uint8_t>* image :
       {&index, &support, &below, &above, &runner_up, &right_support}) {
    image->create(size);
  }
}

void aggregate_paths(const cv::Mat& left, const cv::Mat& right, const SearchRange& range,
                     const Penalties& penalties, int threads, Winners& winners) {
  winners.create(left.size());
  const SweepInput in = prepare(left, right, range, penalties);
  const Band upper{0, 1, left.rows / 2};
  const Band lower{left.rows - 1, -1, left.rows - left.rows / 2};
  const auto sweep_band = [&](const Band& band) { HWY_DYNAMIC_DISPATCH(sweep)(in, band, winners); };
  if (threads > 1) {
    std::jthread other(sweep_band, lower);
    sweep_band(upper);
  } else {
    sweep_band(upper);
    sweep_band(lower);
  }
}

}  // namespace cairn::stereo
#endif
