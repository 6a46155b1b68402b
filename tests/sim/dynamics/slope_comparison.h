// What every test of a gradient asks of it: that differences of the loss itself confirm the slopes which one sweep
// predicts along given directions.
//
//   plateau    central differences over a ladder of steps (coordinator/gradcheck/difference_ladder.h): at least three
//              neighbouring steps, each half the one before, all within tolerance · the largest slope compared. One
//              step alone could agree by chance.
//   not zero   the largest slope is not zero, and what is small in the slope and in the difference does not count as
//              having been compared.
//   Taylor     |loss(h) − loss(0) − h slope| falls as h² over at least three neighbouring halvings of h.
//
// All answers are texts, empty when there is nothing to complain of, so that any test framework can take them.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace knap::test {

// The loss at a distance s along a direction.
using LossAlong = std::function<double(double s)>;

// Slopes of one gradient, whose largest is what errors are measured by.
class SlopeComparison {
 public:
  // `unit`: the ladder's steps are unit · 2^(−10), 2^(−11), … 2^(−30), tried from unit · 2^(−20) outwards.
  void Add(std::string kind, double slope, LossAlong loss, double unit = 1.0);

  // Whether every slope has a plateau. Adds one to (*compared)[kind] for each slope of at least kLeastShare of the
  // largest; may be null.
  std::string Compare(double tolerance, std::map<std::string, int>* compared) const;

  // Of what stays below, agreement says little.
  static constexpr double kLeastShare = 1e-4;

 private:
  struct Slope {
    std::string kind;
    double slope;
    LossAlong loss;
    double unit;
  };
  std::vector<Slope> slopes_;
};

// Over h = unit · 2^(−6), 2^(−7), … 2^(−20): orders of the remainder, log2 of what a halving leaves of it, within
// 2 ± 0.1 three times in a row; or so over −h. A loss with contact has bends in its slope, and one that lies near on
// one side hides the order there.
std::string CheckTaylorRemainder(double slope, const LossAlong& loss, double unit = 1.0);

}  // namespace knap::test
