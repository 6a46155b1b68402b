// What a user does with a tool outside of learning: exports it, starts again from it, and makes a cage around a mesh.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/run_directory/temporary_folder.h"
#include "sim/geometry/mesh_io.h"
#include "tests/cluster/child_process.h"

namespace knap {
namespace own_mesh_test {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

const std::string kConfig = KNAP_SOURCE_DIR "/configs/pushing.yaml";

class OwnMeshTest : public ::testing::Test {
 protected:
  Ended Run(std::vector<std::string> arguments) {
    return RunToEnd(KNAP_PROGRAM, std::move(arguments), folder_ / "", "log");
  }

  // Coarse and short.
  Ended Learn(const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"learn",
                                          "rollout.horizon=2 s",
                                          "rollout.step=4 ms",
                                          "learning.variations=2",
                                          "learning.batch=2",
                                          "learning.max_evaluations=3",
                                          "learning.validation=0",
                                          "learning.keep=last",
                                          "evaluation.variations=2",
                                          "--workers",
                                          "1"};
    arguments.insert(arguments.begin() + 1, more.begin(), more.end());
    return Run(arguments);
  }

  bool AreSame(const std::string& a, const std::string& b) { return ReadText(folder_ / a) == ReadText(folder_ / b); }

  // Each "station_K" of a proposed design: the vertices of the cage's file with its numbers have one x, and no two
  // stations have the same.
  void ExpectStationsToLieInPlanes(const std::string& design, const std::string& cage) {
    const std::vector<Eigen::Vector3d> vertices = ReadMesh(cage, ReadText(folder_ / cage), 1e-3).vertices;
    std::set<double> stations;
    const YAML::Node body = YAML::Load(design)["design"]["bodies"][0];
    for (const YAML::Node& group : body["vertex_groups"]) {
      const auto name = group["name"].as<std::string>();
      if (std::count(name.begin(), name.end(), '_') > 1) continue;  // a side of a station
      const auto numbers = group["vertices"].as<std::vector<std::size_t>>();
      for (const std::size_t i : numbers) EXPECT_EQ(vertices.at(i).x(), vertices.at(numbers[0]).x()) << name;
      EXPECT_TRUE(stations.insert(vertices.at(numbers[0]).x()).second) << name;
    }
    EXPECT_EQ(stations.size(), 4u);
  }

  Json ReadJson(const std::string& name) { return Json::parse(ReadText(folder_ / name)); }

  TemporaryFolder folder_;
};

TEST_F(OwnMeshTest, ARunIsExportedAsItWasWrittenAndLearningGoesOnFromIt) {
  const Ended first = Learn({kConfig, "--out", "first"});
  ASSERT_EQ(first.code, 0) << first.err;
  for (const std::string format : {"stl", "3mf"}) {
    const Ended exported = Run({"export", "first", "--format", format, "--out", "tool." + format});
    ASSERT_EQ(exported.code, 0) << exported.err;
    EXPECT_TRUE(AreSame("tool." + format, "first/tool/learned." + format)) << format;
    EXPECT_FALSE(AreSame("tool." + format, "first/tool/initial." + format)) << format;
  }
  EXPECT_EQ(Run({"export", "first", "--theta", "initial"}).code, 0);
  EXPECT_TRUE(AreSame("pushing.stl", "first/tool/initial.stl"));

  const Json learned = ReadJson("first/result.json")["theta"]["learned"];
  ASSERT_NE(learned, ReadJson("first/result.json")["theta"]["initial"]);
  // With a config of its own, and with the run's.
  for (const std::vector<std::string>& more : {std::vector<std::string>{kConfig, "--from", "first", "--out", "second"},
                                               {"--from", "first", "--out", "third"}}) {
    const Ended again = Learn(more);
    ASSERT_EQ(again.code, 0) << again.err;
    EXPECT_THAT(again.err, HasSubstr("what first learned"));
    EXPECT_EQ(ReadJson(more.back() + "/result.json")["theta"]["initial"], learned);
    EXPECT_EQ(ReadJson(more.back() + "/run.json")["started_from"], "first");
    EXPECT_TRUE(AreSame(more.back() + "/tool/initial.stl", "first/tool/learned.stl"));
  }
  // The first evaluation of the new run is where the old one ended, also when it is resumed.
  fs::remove(folder_ / "second/result.json");
  ASSERT_EQ(Run({"learn", "--resume", "second", "--workers", "1"}).code, 0);
  EXPECT_EQ(ReadJson("second/result.json")["theta"]["initial"], learned);

  const Ended narrow = Learn({kConfig, "--from", "first", "design.parameters.left_depth.lower=-15 mm",
                              "design.parameters.left_depth.upper=0 mm", "design.parameters.right_depth.upper=0 mm"});
  const Ended other = Learn({KNAP_SOURCE_DIR "/configs/gallery/hook.yaml", "--from", "first"});
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, HasSubstr("--from first: that run has no parameter 'tip', which the scenario has"));
  if (learned[3].get<double>() > 0.0 || learned[4].get<double>() > 0.0) {
    EXPECT_EQ(narrow.code, 2);
    EXPECT_THAT(narrow.err, AllOf(HasSubstr("learning.start["), HasSubstr("must lie from")));
  }
  EXPECT_EQ(Run({"learn", "--resume", "second", "--from", "first"}).code, 2);
}

TEST_F(OwnMeshTest, WhatCannotBePrintedIsNotWritten) {
  const Ended refused = Run({"export", KNAP_SOURCE_DIR "/tests/data/mesh/turned_over.yaml", "--theta", "width=-30 mm",
                             "--out", "tool.stl", "--json"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_FALSE(fs::exists(folder_ / "tool.stl"));
  EXPECT_THAT(refused.err, HasSubstr("nothing was written"));
  const Json document = Json::parse(refused.out);
  EXPECT_FALSE(document["written"]);
  EXPECT_TRUE(document["bodies"][0]["file"].is_null());
  const Json& finding = document["bodies"][0]["findings"][0];
  EXPECT_TRUE(finding["error"]);
  EXPECT_EQ(finding["kind"], "mesh");
}

TEST_F(OwnMeshTest, BadArgumentsOfAnExportAreNamed) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--format", "step"}, "--format: 'step': stl, 3mf, obj and glb are allowed"},
      {{"--out", "tool.obj"}, "--out: 'tool.obj': expected a name that ends with .stl"},
      {{"--nozzle", "0"}, "--nozzle: '0': expected a length of more than 0"},
      {{"--nozzle", "3 kg"}, "--nozzle: '3 kg': expected a length"},
      {{"--bed", "250x210"}, "--bed: '250x210': expected width, depth and height"},
      {{"--bed", "250xax210 mm"}, "--bed: 'a mm': expected a length"},
      {{"--theta", "lenght=3 mm"}, "no parameter 'lenght'"},
  };
  for (const auto& [more, message] : cases) {
    std::vector<std::string> arguments = {"export", kConfig};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ended ended = Run(arguments);
    EXPECT_EQ(ended.code, 2) << message;
    EXPECT_THAT(ended.err, HasSubstr(message));
  }
  EXPECT_FALSE(fs::exists(folder_ / "pushing.stl"));
  const Ended nothing =
      Run({"export", KNAP_SOURCE_DIR "/configs/reaching.yaml", "--bed", "1x1x1 cm", "--format", "glb"});
  EXPECT_EQ(nothing.code, 0);
  EXPECT_THAT(nothing.out, HasSubstr("do not fit on the bed, 10 x 10 x 10 mm"));
  EXPECT_TRUE(fs::exists(folder_ / "reaching_palm.glb"));
}

TEST_F(OwnMeshTest, ACageIsMadeThatScenariosTake) {
  fs::copy(KNAP_SOURCE_DIR "/configs/meshes/spool.obj", folder_ / "spool.obj");
  for (const std::string shape : {"box", "prism", "fitted"}) {
    const Ended made = Run({"cage", "spool.obj", "--axis", "x", "--stations", "4", "--shape", shape, "--picture",
                            shape + ".svg", "--out", shape + ".obj"});
    ASSERT_EQ(made.code, 0) << made.err;
    ExpectStationsToLieInPlanes(made.out, shape + ".obj");
    EXPECT_THAT(ReadText(folder_ / (shape + ".svg")), AllOf(HasSubstr("offset_4_z"), HasSubstr("</svg>")));
    std::ofstream(folder_ / (shape + ".yaml"))
        << "schema: 2\nname: own\nbodies:\n"
           "  - {name: tool, joint: {type: fixed}, shapes: [{type: designed_mesh}]}\n"
           "rollout: {horizon: 1 s}\n"
        << made.out;
    const Ended valid = Run({"validate", shape + ".yaml"});
    EXPECT_EQ(valid.code, 0) << valid.err;
    EXPECT_THAT(valid.out, AllOf(HasSubstr("19 design parameters"), HasSubstr("as on file"), HasSubstr("width_2")));
  }
  EXPECT_EQ(Run({"cage", "spool.obj", "--axis", "w"}).code, 2);
  EXPECT_EQ(Run({"cage", "spool.obj", "--axis", "x", "--stations", "1"}).code, 2);
  EXPECT_EQ(Run({"cage", "missing.stl", "--axis", "x"}).code, 2);
  std::ofstream(folder_ / "open.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const Ended open = Run({"cage", "open.obj", "--axis", "x"});
  EXPECT_EQ(open.code, 2);
  EXPECT_THAT(open.err, HasSubstr("open.obj: must be closed and face outwards; it has 3 open edges"));
}

}  // namespace own_mesh_test
}  // namespace knap
