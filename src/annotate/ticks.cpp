// SPDX-License-Identifier: Apache-2.0
#include "annotate/ticks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "view/look/value_scale.h"

namespace ovoid::annotate {
namespace {

// Plain numbers up to this length need no exponent, even if it were shorter: 100000 reads better
// than 1e5.
constexpr std::size_t kPlain = 6;

// Multiples of a step are told apart safely up to this count: doubles have 15 to 17 digits.
constexpr double kMostMultiples = 1e15;

// 10^e as the double nearest to it where doubles can (e >= -22 by division).
double power_of_ten(int e) { return e >= 0 ? std::pow(10.0, e) : 1.0 / std::pow(10.0, -e); }

int exponent_of(double value) { return static_cast<int>(std::floor(std::log10(std::abs(value)))); }

struct Step {
  int mantissa = 1;  // 1, 2 or 5
  int exponent = 0;

  // i steps; the nearest double to the decimal number where that is short.
  double times(double i) const {
    return exponent >= 0 ? i * mantissa * power_of_ten(exponent)
                         : i * mantissa / power_of_ten(-exponent);
  }
  double size() const { return times(1); }
  Step next() const {
    if (mantissa == 1) return {2, exponent};
    return mantissa == 2 ? Step{5, exponent} : Step{1, exponent + 1};
  }
};

// "2.50e+07" to "2.5e7".
std::string tidy_exponent(const std::string& text) {
  const std::size_t e = text.find('e');
  return fmt::format("{}e{}", text.substr(0, e), std::stoi(text.substr(e + 1)));
}

void strip_zeros(std::string& text) {
  if (text.find('.') == std::string::npos) return;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
}

std::size_t digits_of(const std::string& text) { return text.size() - (text[0] == '-' ? 1 : 0); }

std::size_t longest(const std::vector<Tick>& ticks) {
  std::size_t length = 0;
  for (const Tick& tick : ticks) length = std::max(length, digits_of(tick.label));
  return length;
}

// Labels of multiples of a step: all with the step's decimals, or all with an exponent and the
// digits that reach down to the step's, whichever is shorter.
void label_multiples(std::vector<Tick>& ticks, const Step& step) {
  std::vector<Tick> plain = ticks;
  for (Tick& tick : plain) {
    tick.label = fmt::format("{:.{}f}", tick.value, std::clamp(-step.exponent, 0, 340));
  }
  for (Tick& tick : ticks) {
    if (tick.value == 0) {
      tick.label.assign(1, '0');
      continue;
    }
    const int digits = std::clamp(exponent_of(tick.value) - step.exponent, 0, 17);
    tick.label = fmt::format("{:.{}e}", tick.value, digits);
    std::string mantissa = tick.label.substr(0, tick.label.find('e'));
    const std::string exponent = tick.label.substr(tick.label.find('e'));
    strip_zeros(mantissa);
    tick.label = tidy_exponent(mantissa + exponent);
  }
  if (longest(plain) <= std::max(kPlain, longest(ticks))) ticks = std::move(plain);
}

Step step_below(double limit) {
  Step step{1, exponent_of(limit)};
  if (step.size() > limit) --step.exponent;  // the logarithm's rounding
  while (step.next().size() <= limit) step = step.next();
  return step;
}

}  // namespace

double round_below(double limit) { return step_below(limit).size(); }

std::vector<Tick> linear_ticks(double lo, double hi, int most) {
  // By halves, because the span of finite numbers may not be one.
  const double half_span = hi / 2 - lo / 2;
  const double least_step = half_span / (most - 1) * 2;
  if (!(least_step >= std::numeric_limits<double>::min())) return {};
  if (std::max(std::abs(lo), std::abs(hi)) / least_step > kMostMultiples) return {};
  Step step = step_below(least_step);
  // Widened for the division's rounding; what is outside is left out below.
  const auto first = [&] {
    return std::ceil(lo / step.size() - 1e-15 * std::abs(lo / step.size()));
  };
  const auto last = [&] {
    return std::floor(hi / step.size() + 1e-15 * std::abs(hi / step.size()));
  };
  while (last() - first() + 1 > most) step = step.next();
  std::vector<Tick> ticks;
  for (double i = first(); i <= last(); ++i) {
    const double value = step.times(i) + 0.0;  // no negative zero
    if (value >= lo && value <= hi) ticks.push_back({value, {}});
  }
  label_multiples(ticks, step);
  return ticks;
}

TickScale::TickScale(ValueScale kind, double lo, double hi, double linear_width)
    : kind_(kind), lo_(lo), hi_(hi), linear_width_(linear_width) {
  if (kind_ == ValueScale::kLog && !(lo_ > 0)) kind_ = ValueScale::kLinear;
  if (kind_ == ValueScale::kSymlog && !(linear_width_ > 0)) kind_ = ValueScale::kLinear;
  warped_lo_ = warp(lo_);
  warped_hi_ = warp(hi_);
}

// As colours run; on a linear scale by halves, as in linear_ticks().
double TickScale::warp(double value) const {
  if (kind_ == ValueScale::kLinear) return value / 2;
  return view::along(kind_, linear_width_, value);
}

double TickScale::unwarp(double warped) const {
  if (kind_ == ValueScale::kLinear) return warped * 2;
  return view::value_at(kind_, linear_width_, warped);
}

double TickScale::place(double value) const {
  if (!(warped_lo_ < warped_hi_)) return 0.5;
  return (warp(value) - warped_lo_) / (warped_hi_ - warped_lo_);
}

double TickScale::value(double place) const {
  return std::clamp(unwarp(warped_lo_ + place * (warped_hi_ - warped_lo_)), lo_, hi_);
}

std::vector<Tick> TickScale::ticks(int most) const {
  if (kind_ == ValueScale::kLog) return log_ticks(most);
  if (kind_ == ValueScale::kSymlog) return symlog_ticks(most);
  return linear_ticks(lo_, hi_, most);
}

std::vector<Tick> TickScale::log_ticks(int most) const {
  const int first = static_cast<int>(std::ceil(warped_lo_ - 1e-12));
  const int last = static_cast<int>(std::floor(warped_hi_ + 1e-12));
  std::vector<Tick> ticks;
  if (last - first >= 2) {  // three powers of ten and more
    const int every = (last - first) / most + 1;
    for (int e = first; e <= last; ++e) {
      const double value = power_of_ten(e);
      if (e % every == 0 && value >= lo_ && value <= hi_) ticks.push_back({value, {}});
    }
  } else {
    for (int e = first - 1; e <= last; ++e) {
      for (const int mantissa : {1, 2, 5}) {
        const double value = Step{mantissa, e}.size();
        if (value >= lo_ && value <= hi_) ticks.push_back({value, {}});
      }
    }
  }
  if (ticks.size() < 3) return linear_ticks(lo_, hi_, most);
  for (Tick& tick : ticks) tick.label = number_text(tick.value);
  return ticks;
}

std::vector<Tick> TickScale::symlog_ticks(int most) const {
  // Zero, and powers of ten to both sides from the linear part on.
  std::vector<Tick> ticks;
  const double greatest = std::max(std::abs(lo_), std::abs(hi_));
  const int first = static_cast<int>(std::ceil(std::log10(linear_width_) - 1e-12));
  const int last = greatest > 0 ? static_cast<int>(std::floor(std::log10(greatest))) : first;
  const int sides = lo_ < 0 && hi_ > 0 ? 2 : 1;
  const int every = std::max(0, last - first) * sides / most + 1;
  for (int e = last; e >= first; --e) {
    if (lo_ <= -power_of_ten(e) && (e - first) % every == 0)
      ticks.push_back({-power_of_ten(e), {}});
  }
  if (lo_ <= 0 && hi_ >= 0) ticks.push_back({0, {}});
  for (int e = first; e <= last; ++e) {
    const double value = power_of_ten(e);
    if (value >= lo_ && value <= hi_ && (e - first) % every == 0) ticks.push_back({value, {}});
  }
  std::erase_if(ticks, [this](const Tick& tick) { return tick.value < lo_ || tick.value > hi_; });
  if (ticks.size() < 2) return linear_ticks(lo_, hi_, most);
  for (Tick& tick : ticks) tick.label = number_text(tick.value);
  return ticks;
}

std::string number_text(double value, double resolution) {
  if (value == 0) return "0";
  std::string plain;
  std::string scientific;
  if (resolution > 0) {
    const int least = exponent_of(resolution);
    plain = fmt::format("{:.{}f}", value, std::clamp(-least, 0, 340));
    strip_zeros(plain);
    if (plain == "0" || plain == "-0") return "0";
    scientific = fmt::format("{:.{}e}", value, std::clamp(exponent_of(value) - least, 0, 17));
  } else {
    std::array<char, 32> digits{};  // the fewest that read back the same
    char* const end =
        std::to_chars(digits.begin(), digits.end(), value, std::chars_format::scientific).ptr;
    scientific = std::string(digits.begin(), end);
    const std::size_t at = scientific.find('e');
    const int decimals = std::max(0, static_cast<int>(at) - (value < 0 ? 1 : 0) - 2);
    const int exponent = std::stoi(scientific.substr(at + 1));
    plain = fmt::format("{:.{}f}", value, std::clamp(decimals - exponent, 0, 340));
    strip_zeros(plain);
  }
  const std::size_t e = scientific.find('e');
  std::string mantissa = scientific.substr(0, e);
  strip_zeros(mantissa);
  scientific = tidy_exponent(mantissa + scientific.substr(e));
  return digits_of(plain) <= std::max(kPlain, digits_of(scientific)) ? plain : scientific;
}

}  // namespace ovoid::annotate
