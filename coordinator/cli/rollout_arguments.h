// Designs and variations as they are written on the command line.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "coordinator/learning/problem.h"
#include "sim/scenarios/scenario_files.h"
#include "sim/scenarios/scene.h"

namespace knap {

// The index of a parameter by its name. Throws UsageError that begins with `option` and names what is near, or allowed.
std::size_t FindParameter(const std::string& name, const std::string& option, const ParameterSpec& parameters);

// One design: "initial"; "NAME=VALUE,…" with units, "depth=10 mm", the others as in `others`; or all d values,
// "v1,v2,…", in SI or with units. It may lie outside the bounds. Throws UsageError that begins with `option` for an
// unknown or repeated name, a wrong number of values and what has not the parameter's dimension.
std::vector<double> ParseTheta(const std::string& text, const std::string& option, const ParameterSpec& parameters,
                               const std::vector<double>& others);

// Values for the scene's varied keys in their order, "v1,v2,…", each an SI number or with its unit. Throws
// UsageError that begins with `option` for a wrong number of values, what is none of the key's, and values
// that the key does not allow.
std::vector<double> ParseVariationValues(const std::string& text, const std::string& option, Scene scene);

// What the file itself gives for the varied keys.
std::vector<double> ReadNominalVariation(Scene scene);

// Variation `number` of the stream that tests draw from; `seed` or, without one, evaluation.seed.
std::vector<double> SampleTestVariation(const LoadedScenario& scenario, std::optional<std::uint64_t> seed,
                                        std::uint64_t number);

// The last `count` of `values` are controls or weights, the others design.
void SplitControls(const std::vector<double>& values, std::size_t count, Eigen::VectorXd* design,
                   Eigen::VectorXd* controls);

// `text` as one word of a shell's command line.
std::string QuoteForShell(const std::string& text);

}  // namespace knap
