// What the values of a request are, in their order: theta | controls | reference | variation | nodes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "knap/assignment_t.hpp"

namespace knap {

inline std::int64_t CountValues(const assignment_t& assignment) {
  return std::int64_t{assignment.theta_size} + assignment.control_size + assignment.reference_size +
         assignment.variation_size + assignment.nodes_size;
}

// Views of `values`, which holds CountValues(assignment) of them.
struct RequestValues {
  std::span<const double> theta, controls, reference, variation, nodes;

  RequestValues(const assignment_t& assignment, std::span<const double> values) {
    const auto take = [&values](std::int32_t count) {
      const std::span<const double> front = values.first(static_cast<std::size_t>(count));
      values = values.subspan(front.size());
      return front;
    };
    theta = take(assignment.theta_size);
    controls = take(assignment.control_size);
    reference = take(assignment.reference_size);
    variation = take(assignment.variation_size);
    nodes = take(assignment.nodes_size);
  }
};

}  // namespace knap
