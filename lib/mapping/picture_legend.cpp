// SPDX-License-Identifier: Apache-2.0
#include "mapping/picture_legend.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace cairn::mapping {
namespace {

const cv::Scalar kPaper{255, 255, 255};
const cv::Scalar kInk{60, 50, 45};
constexpr int kRow_px = 34;
constexpr int kInset_px = 14;
constexpr int kGap_px = 8;       ///< between a sign and its text
constexpr int kItemGap_px = 26;  ///< between a text and the next sign
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kFontScale = 0.45;

/// The longest of 1, 2, 5 times a power of ten that is no longer than this.
double round_length_m(double longest_m) {
  const double power = std::pow(10, std::floor(std::log10(longest_m)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= longest_m) return factor * power;
  }
  return power;
}

std::string length_text(double length_m) {
  if (length_m >= 1) return std::to_string(std::lround(length_m)) + " m";
  if (length_m >= 0.01) return std::to_string(std::lround(length_m * 100)) + " cm";
  return std::to_string(std::lround(length_m * 1000)) + " mm";
}

LegendItem scale_bar(int width_px, double pixels_per_m) {
  const double length_m = round_length_m(0.25 * width_px / pixels_per_m);
  const int length_px = std::max(1, static_cast<int>(std::lround(length_m * pixels_per_m)));
  cv::Mat bar(12, length_px, CV_8UC3, kPaper);
  cv::rectangle(bar, {0, 4}, {length_px - 1, 7}, kInk, cv::FILLED);
  for (const int end : {0, length_px - 2}) {
    cv::rectangle(bar, {end, 0}, {end + 1, 11}, kInk, cv::FILLED);
  }
  return {bar, length_text(length_m)};
}

int width_px(const LegendItem& item) {
  int below = 0;
  return item.sign.cols + kGap_px + cv::getTextSize(item.text, kFont, kFontScale, 1, &below).width;
}

void draw(const LegendItem& item, cv::Mat& strip, cv::Point at) {
  const cv::Rect place(at.x, at.y + (kRow_px - item.sign.rows) / 2, item.sign.cols, item.sign.rows);
  const cv::Rect shown = place & cv::Rect(0, 0, strip.cols, strip.rows);
  item.sign(shown - place.tl()).copyTo(strip(shown));
  cv::putText(strip, item.text, {place.br().x + kGap_px, at.y + kRow_px / 2 + 5}, kFont, kFontScale,
              kInk, 1, cv::LINE_AA);
}

}  // namespace

cv::Mat with_legend(const cv::Mat& picture, double pixels_per_m,
                    const std::vector<LegendItem>& items) {
  std::vector<LegendItem> all{scale_bar(picture.cols, pixels_per_m)};
  all.insert(all.end(), items.begin(), items.end());
  std::vector<cv::Point> places;
  cv::Point next(kInset_px, 3);
  for (const LegendItem& item : all) {
    if (next.x > kInset_px && next.x + width_px(item) > picture.cols - kInset_px)
      next = {kInset_px, next.y + kRow_px};
    places.push_back(next);
    next.x += width_px(item) + kItemGap_px;
  }
  cv::Mat framed;
  cv::copyMakeBorder(picture, framed, 0, next.y + kRow_px + 3, 0, 0, cv::BORDER_CONSTANT, kPaper);
  cv::Mat strip = framed.rowRange(picture.rows, framed.rows);
  for (std::size_t i = 0; i < all.size(); ++i) draw(all[i], strip, places[i]);
  return framed;
}

}  // namespace cairn::mapping
