// Random numbers that are a pure function of (seed, stream, index): no state to save, no order to keep.
//
// The generator is Philox4x32-10 (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011).
// For a fixed key it is a bijection of the 128-bit counter, and the counter is laid out as
//
//   word 0: block number within one index    words 1, 2: index (low, high)    word 3: stream
//
// with the seed as key. Two streams of one seed therefore never share a counter: they are disjoint by construction.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace knap {

// What a stream of numbers is for. The values are part of what makes a run reproducible: never reuse or renumber one.
enum class RandomStream : std::uint32_t {
  kTrainingVariations = 1,  // index: training variation
  kTestVariations = 2,      // index: test variation
  kDistillation = 3,        // index: batch
  kFirstBatch = 4,          // index: variation of the batch B_0 of the method diffhand
  kRandomThetas = 5,        // index: number of the random design
  kOptimizer = 6,           // index: batch; seeds NLopt's stochastic algorithms
  kPolicyWeights = 7,       // index: weight of a policy's network
  kValidation = 8,          // index: validation variation
  kDemonstrations = 9,      // index: variation that is demonstrated to a policy
  kGenerations = 10,        // index: generation of an evolution strategy, whose seed is one of kOptimizer
};

// Ten rounds of Philox4x32 on one counter.
std::array<std::uint32_t, 4> CalcPhilox4x32(const std::array<std::uint32_t, 4>& counter,
                                            const std::array<std::uint32_t, 2>& key);

// The standard normal quantile z with Phi(z) = p, for p in (0, 1); relative error about 1e-15. Wichura's rational
// approximation (Algorithm AS 241, PPND16, Applied Statistics 37, 1988). It uses + - * / and sqrt alone, which IEEE 754
// rounds exactly, and a logarithm built from them: no libm variant of the processor can change a bit.
double CalcNormalQuantile(double p);

// Phi(z) for z <= 0, within 2^-62: the inverse of CalcNormalQuantile by bisection, for the same reason.
double CalcNormalLowerTail(double z);

// The sequence of numbers at one (seed, stream, index). Copy it to repeat it. Not shared between threads.
class CounterRandom {
 public:
  CounterRandom(std::uint64_t seed, RandomStream stream, std::uint64_t index);

  std::uint64_t DrawBits();                        // 64 uniform bits
  double DrawUniform();                            // a multiple of 2^-53 in [0, 1)
  double DrawUniform(double lower, double upper);  // in [lower, upper]; lower <= upper, both finite
  double DrawNormal();                             // mean 0, standard deviation 1; one 64-bit draw each
  // The same conditioned on |z| <= limit, limit > 0, by inversion: z = quantile(Phi(-limit) + u (1 - 2 Phi(-limit))).
  // One 64-bit draw; an infinite limit gives DrawNormal's bits.
  double DrawTruncatedNormal(double limit);
  std::uint64_t DrawBelow(std::uint64_t bound);  // uniform on 0 … bound-1 without bias; bound > 0

  // `count` different numbers of 0 … population-1, each subset and order equally likely, in the order drawn
  // (Fisher–Yates). Throws std::invalid_argument when count > population.
  std::vector<std::uint64_t> DrawWithoutReplacement(std::uint64_t population, std::uint64_t count);

 private:
  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> counter_;
  std::array<std::uint32_t, 4> block_{};
  int words_left_ = 0;  // of block_, taken two at a time
};

}  // namespace knap
