#include "coordinator/cli/rollout_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iostream>
#include <istream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "coordinator/cli/rollout_arguments.h"
#include "coordinator/cli/rollout_record.h"
#include "coordinator/run/loss_unit.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/json_text.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

constexpr std::size_t kLongestLine = std::size_t{1} << 26;  // more than a million numbers

// False at the end of the input. A longer line than is allowed comes cut, by one byte too long.
bool ReadLine(std::istream& in, std::string* line) {
  line->clear();
  char c = 0;
  bool any = false;
  while (in.get(c)) {
    any = true;
    if (c == '\n') return true;
    if (line->size() <= kLongestLine) line->push_back(c);
  }
  return any;
}

double ReadNumber(const nlohmann::json& value, const std::string& where) {
  if (!value.is_number()) throw UsageError(fmt::format("{}: value {}: expected a number", where, value.dump()));
  return value.get<double>();
}

class RolloutServer {
 public:
  RolloutServer(const LoadedScenario& scenario, const ParameterSpec& parameters, const NamedDesigns& designs,
                RolloutModel* model)
      : scenario_(scenario),
        scene_(scenario.parsed.scene),
        parameters_(parameters),
        designs_(designs),
        model_(model),
        keys_(ListVariedKeys(scene_.variation)),
        nominal_(ReadNominalVariation(scene_)) {}

  nlohmann::ordered_json Introduce() const {
    nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < parameters_.names.size(); ++i) {
      parameters.push_back({{"name", parameters_.names[i]},
                            {"unit", parameters_.GetUnit(i)},
                            {"lower", parameters_.lower[i]},
                            {"upper", parameters_.upper[i]},
                            {"initial", parameters_.initial[i]}});
    }
    nlohmann::ordered_json variation = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < keys_.size(); ++i) variation.push_back({{"key", keys_[i]}, {"nominal", nominal_[i]}});
    return {{"server", 1},
            {"scenario", scene_.name},
            {"loss_unit", FormatLossUnit(scene_)},
            {"parameters", std::move(parameters)},
            {"variation", std::move(variation)}};
  }

  nlohmann::ordered_json Answer(const std::string& line) {
    nlohmann::json id;
    try {
      if (line.size() > kLongestLine) throw UsageError(fmt::format("a line of more than {} bytes", kLongestLine));
      const nlohmann::json request = nlohmann::json::parse(line);
      if (!request.is_object()) throw UsageError("expected an object, such as {\"theta\": [0.01, 0.02]}");
      id = request.value("id", nlohmann::json());
      nlohmann::ordered_json answer{{"id", id}};
      answer.update(Run(request));
      return answer;
    } catch (const nlohmann::json::exception& e) {
      return {{"id", id}, {"error", CleanText(e.what())}};
    } catch (const std::invalid_argument& e) {
      return {{"id", id}, {"error", CleanText(e.what())}};
    } catch (const UsageError& e) {
      return {{"id", id}, {"error", CleanText(e.what())}};
    }
  }

 private:
  nlohmann::ordered_json Run(const nlohmann::json& request) {
    static const std::set<std::string> known = {"id", "theta", "reference_theta", "variation", "gradient"};
    for (const auto& [key, value] : request.items()) {
      if (!known.contains(key)) {
        throw UsageError(fmt::format("{}: not a key; id, theta, reference_theta, variation and gradient are",
                                     nlohmann::json(key).dump()));
      }
    }
    RolloutInput input;
    SplitControls(ReadTheta(request.value("theta", nlohmann::json()), "theta"), parameters_.controls, &input.theta,
                  &input.controls);
    if (request.contains("reference_theta")) {
      SplitControls(ReadTheta(request.at("reference_theta"), "reference_theta"), parameters_.controls,
                    &input.theta_reference, &input.controls_reference);
    }
    input.variation = ReadVariation(request.value("variation", nlohmann::json()));
    const nlohmann::json wanted = request.value("gradient", nlohmann::json(true));
    if (!wanted.is_boolean()) throw UsageError("gradient: expected true or false");
    input.want_gradient = wanted.get<bool>();
    const RolloutOutput output = model_->Run(input, {});
    return MakeRolloutJson({scene_, parameters_, input, output, model_->forward_s, model_->gradient_s});
  }

  // Null: the default design.
  std::vector<double> ReadTheta(const nlohmann::json& value, const std::string& where) const {
    if (value.is_null()) return ChooseTheta("", parameters_, designs_);
    if (value.is_string()) return ChooseTheta(value.get<std::string>(), parameters_, designs_);
    if (value.is_array()) return ReadList(value, parameters_.names, where);
    std::vector<double> theta = ChooseTheta("", parameters_, designs_);
    for (const auto& [name, number] : value.items()) {
      theta[FindParameter(name, where, parameters_)] = ReadNumber(number, where + "." + name);
    }
    return theta;
  }

  // Null: the file's own values.
  std::vector<double> ReadVariation(const nlohmann::json& value) const {
    if (value.is_null()) return nominal_;
    if (value.is_number_unsigned()) return SampleTestVariation(scenario_, {}, value.get<std::uint64_t>());
    if (value.is_array()) return ReadList(value, keys_, "variation");
    if (!value.is_object()) throw UsageError("variation: expected numbers, an object by keys or a number from 0");
    std::vector<double> values = nominal_;
    for (const auto& [key, number] : value.items()) {
      const auto at = std::find(keys_.begin(), keys_.end(), key);
      if (at == keys_.end())
        throw UsageError(fmt::format("variation: {} is not a varied key", nlohmann::json(key).dump()));
      values[static_cast<std::size_t>(at - keys_.begin())] = ReadNumber(number, "variation." + key);
    }
    return values;
  }

  std::vector<double> ReadList(const nlohmann::json& list, const std::vector<std::string>& names,
                               const std::string& where) const {
    if (list.size() != names.size()) {
      throw UsageError(fmt::format("{}: {} values; the scenario has {}", where, list.size(), names.size()));
    }
    std::vector<double> values;
    for (std::size_t i = 0; i < names.size(); ++i) values.push_back(ReadNumber(list[i], where + "." + names[i]));
    return values;
  }

  const LoadedScenario& scenario_;
  const Scene& scene_;
  const ParameterSpec& parameters_;
  const NamedDesigns& designs_;
  RolloutModel* model_;
  const std::vector<std::string> keys_;
  const std::vector<double> nominal_;
};

}  // namespace

void ServeRollouts(const LoadedScenario& scenario, const ParameterSpec& parameters, const NamedDesigns& designs,
                   RolloutModel* model) {
  RolloutServer server(scenario, parameters, designs, model);
  WriteOutput(MakeJsonText(server.Introduce(), -1) + "\n");
  for (std::string line; ReadLine(std::cin, &line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    WriteOutput(MakeJsonText(server.Answer(line), -1) + "\n");
  }
}

}  // namespace knap
