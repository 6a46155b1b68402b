#include "coordinator/random/counter_random.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "coordinator/random/exact_functions.h"

namespace knap {
namespace {

constexpr std::uint32_t kMultiplier0 = 0xD2511F53u;
constexpr std::uint32_t kMultiplier1 = 0xCD9E8D57u;
constexpr std::uint32_t kWeyl0 = 0x9E3779B9u;  // golden ratio
constexpr std::uint32_t kWeyl1 = 0xBB67AE85u;  // sqrt(3) - 1
constexpr int kRounds = 10;

std::uint32_t GetLow(std::uint64_t x) { return static_cast<std::uint32_t>(x); }
std::uint32_t GetHigh(std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); }

// sum_k c[k] x^k, by Horner's rule in a fixed order.
template <std::size_t n>
double CalcPolynomial(const double (&c)[n], double x) {
  double sum = c[n - 1];
  for (std::size_t k = n - 1; k-- > 0;) sum = sum * x + c[k];
  return sum;
}

}  // namespace

std::array<std::uint32_t, 4> CalcPhilox4x32(const std::array<std::uint32_t, 4>& counter,
                                            const std::array<std::uint32_t, 2>& key) {
  std::array<std::uint32_t, 4> c = counter;
  std::array<std::uint32_t, 2> k = key;
  for (int round = 0; round < kRounds; ++round) {
    const std::uint64_t product0 = std::uint64_t{kMultiplier0} * c[0];
    const std::uint64_t product1 = std::uint64_t{kMultiplier1} * c[2];
    c = {GetHigh(product1) ^ c[1] ^ k[0], GetLow(product1), GetHigh(product0) ^ c[3] ^ k[1], GetLow(product0)};
    k[0] += kWeyl0;
    k[1] += kWeyl1;
  }
  return c;
}

double CalcNormalQuantile(double p) {
  if (!(p > 0.0 && p < 1.0)) {
    throw std::invalid_argument("CalcNormalQuantile: p is " + std::to_string(p) + ", allowed is 0 < p < 1");
  }
  // The coefficients a … f of AS 241, numerators and denominators in ascending powers.
  static constexpr double kA[] = {3.3871328727963666080e0,  1.3314166789178437745e+2, 1.9715909503065514427e+3,
                                  1.3731693765509461125e+4, 4.5921953931549871457e+4, 6.7265770927008700853e+4,
                                  3.3430575583588128105e+4, 2.5090809287301226727e+3};
  static constexpr double kB[] = {1.0,
                                  4.2313330701600911252e+1,
                                  6.8718700749205790830e+2,
                                  5.3941960214247511077e+3,
                                  2.1213794301586595867e+4,
                                  3.9307895800092710610e+4,
                                  2.8729085735721942674e+4,
                                  5.2264952788528545610e+3};
  static constexpr double kC[] = {1.42343711074968357734e0,  4.63033784615654529590e0, 5.76949722146069140550e0,
                                  3.64784832476320460504e0,  1.27045825245236838258e0, 2.41780725177450611770e-1,
                                  2.27238449892691845833e-2, 7.74545014278341407640e-4};
  static constexpr double kD[] = {1.0,
                                  2.05319162663775882187e0,
                                  1.67638483018380384940e0,
                                  6.89767334985100004550e-1,
                                  1.48103976427480074590e-1,
                                  1.51986665636164571966e-2,
                                  5.47593808499534494600e-4,
                                  1.05075007164441684324e-9};
  static constexpr double kE[] = {6.65790464350110377720e0,  5.46378491116411436990e0,  1.78482653991729133580e0,
                                  2.96560571828504891230e-1, 2.65321895265761230930e-2, 1.24266094738807843860e-3,
                                  2.71155556874348757815e-5, 2.01033439929228813265e-7};
  static constexpr double kF[] = {1.0,
                                  5.99832206555887937690e-1,
                                  1.36929880922735805310e-1,
                                  1.48753612908506148525e-2,
                                  7.86869131145613259100e-4,
                                  1.84631831751005468180e-5,
                                  1.42151175831644588870e-7,
                                  2.04426310338993978564e-15};
  const double q = p - 0.5;
  if (std::abs(q) <= 0.425) {
    const double r = 0.180625 - q * q;
    return q * CalcPolynomial(kA, r) / CalcPolynomial(kB, r);
  }
  double r = std::sqrt(-CalcLogarithm(q < 0.0 ? p : 1.0 - p));
  double z = 0.0;
  if (r <= 5.0) {
    r -= 1.6;
    z = CalcPolynomial(kC, r) / CalcPolynomial(kD, r);
  } else {
    r -= 5.0;
    z = CalcPolynomial(kE, r) / CalcPolynomial(kF, r);
  }
  return q < 0.0 ? -z : z;
}

double CalcNormalLowerTail(double z) {
  if (std::isinf(z)) return 0.0;
  double below = 0.0, above = 0.5;  // quantile(below) < z <= quantile(above)
  for (int i = 0; i < 61; ++i) {
    const double middle = 0.5 * (below + above);
    (CalcNormalQuantile(middle) < z ? below : above) = middle;
  }
  return below;
}

CounterRandom::CounterRandom(std::uint64_t seed, RandomStream stream, std::uint64_t index)
    : key_{GetLow(seed), GetHigh(seed)},
      counter_{0, GetLow(index), GetHigh(index), static_cast<std::uint32_t>(stream)} {}

std::uint64_t CounterRandom::DrawBits() {
  if (words_left_ == 0) {
    block_ = CalcPhilox4x32(counter_, key_);
    // A wrap would repeat the sequence, silently: 2^33 numbers at one index are far beyond any use here.
    if (++counter_[0] == 0) throw std::length_error("CounterRandom: more than 2^33 numbers drawn at one index");
    words_left_ = 4;
  }
  const auto first = static_cast<std::size_t>(4 - words_left_);
  words_left_ -= 2;
  return (std::uint64_t{block_[first + 1]} << 32) | block_[first];
}

double CounterRandom::DrawUniform() { return static_cast<double>(DrawBits() >> 11) * 0x1p-53; }

double CounterRandom::DrawUniform(double lower, double upper) {
  return std::min(upper, lower + DrawUniform() * (upper - lower));
}

double CounterRandom::DrawNormal() { return DrawTruncatedNormal(std::numeric_limits<double>::infinity()); }

double CounterRandom::DrawTruncatedNormal(double limit) {
  if (!(limit > 0.0)) {
    throw std::invalid_argument("CounterRandom::DrawTruncatedNormal: limit " + std::to_string(limit) +
                                ", allowed is > 0");
  }
  // The midpoints of 2^52 equal cells of (0, 1) are exact in double and never 0 or 1.
  const double u = (static_cast<double>(DrawBits() >> 12) + 0.5) * 0x1p-52;
  const double tail = CalcNormalLowerTail(-limit);
  // Rounding must not carry a draw beyond the limit.
  return std::clamp(CalcNormalQuantile(tail + u * (1.0 - 2.0 * tail)), -limit, limit);
}

std::uint64_t CounterRandom::DrawBelow(std::uint64_t bound) {
  if (bound == 0) throw std::invalid_argument("CounterRandom::DrawBelow: bound is 0, allowed is 1 and more");
  // Of the 2^64 values the first 2^64 mod bound are refused; the rest falls evenly on the remainders.
  const std::uint64_t refused = (0 - bound) % bound;
  std::uint64_t bits = DrawBits();
  while (bits < refused) bits = DrawBits();
  return bits % bound;
}

std::vector<std::uint64_t> CounterRandom::DrawWithoutReplacement(std::uint64_t population, std::uint64_t count) {
  if (count > population) {
    throw std::invalid_argument("CounterRandom::DrawWithoutReplacement: count " + std::to_string(count) +
                                " exceeds the population of " + std::to_string(population));
  }
  std::vector<std::uint64_t> numbers(population);
  std::iota(numbers.begin(), numbers.end(), std::uint64_t{0});
  for (std::uint64_t i = 0; i < count; ++i) std::swap(numbers[i], numbers[i + DrawBelow(population - i)]);
  numbers.resize(count);
  return numbers;
}

}  // namespace knap
