// configs/pushing.yaml says what the scene is meant to be.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <fstream>
#include <sstream>
#include <utility>

#include "sim/scenarios/parse_scene.h"

namespace knap {
namespace pushing_config_test {

class PushingConfig : public testing::Test {
 protected:
  void SetUp() override {
    std::ifstream stream(KNAP_CONFIGS "/pushing.yaml");
    ASSERT_TRUE(stream) << KNAP_CONFIGS;
    std::ostringstream text;
    text << stream.rdbuf();
    ParseResult result = ParseScene(text.str(), "pushing.yaml");
    ASSERT_TRUE(result.ok()) << result.FormatErrors();
    scene_ = std::move(result.scene);
  }

  // Where the moves put a point that follows a station and lies at (x, 0) on file.
  Eigen::Vector2d CalcStation(int station, double x, const Eigen::VectorXd& theta) const {
    Eigen::Vector2d p(x, 0.0);
    const Design& design = *scene_.design;
    for (const CageMove& move : design.bodies.at(0).moves) {
      for (const VertexGroup& group : design.bodies.at(0).vertex_groups) {
        if (group.name != move.group || group.vertices.at(1) != 4 * station + 1) continue;
        for (std::size_t k = 0; k < design.parameters.size(); ++k) {
          if (design.parameters[k].name != move.parameter) continue;
          p += (theta(static_cast<Eigen::Index>(k)) - design.parameters[k].initial) * move.direction.head<2>();
        }
      }
    }
    return p;
  }

  Scene scene_;
};

constexpr double kStations[] = {-0.052, -0.037, -0.022,
                                0.022,  0.037,  0.052};  // x of the tool's own stations, inside the cage [m]

TEST_F(PushingConfig, HasSevenParametersAndCapsTheWidth) {
  const std::vector<DesignParameter>& parameters = scene_.design->parameters;
  ASSERT_EQ(parameters.size(), 7u);
  EXPECT_DOUBLE_EQ(parameters[0].initial + parameters[1].initial + parameters[2].initial, 0.104);
  EXPECT_LE(parameters[0].upper + parameters[1].upper + parameters[2].upper, 0.120 + 1e-12);
}

TEST_F(PushingConfig, ParametersMeanWhatTheirNamesSay) {
  Eigen::VectorXd theta(7);
  theta << 0.050, 0.020, 0.024, 0.012, -0.008, 0.004, -0.002;
  const double x_middle = 0.025;
  const Eigen::Vector2d expected[] = {
      {-x_middle - 0.020, 0.012},         {-x_middle - 0.010, 0.006 + 0.004}, {-x_middle, 0.0}, {x_middle, 0.0},
      {x_middle + 0.012, -0.004 - 0.002}, {x_middle + 0.024, -0.008}};
  for (int station = 0; station < 6; ++station) {
    const Eigen::Vector2d p = CalcStation(station, kStations[station], theta);
    // Some decimal numbers of millimetres, added up: a few roundings of 1e-17 m.
    EXPECT_LT((p - expected[station]).norm(), 1e-15) << station;
  }
}

TEST_F(PushingConfig, EveryVertexOfTheCageIsInOneGroup) {
  std::vector<int> count(24, 0);
  for (const VertexGroup& group : scene_.design->bodies.at(0).vertex_groups) {
    for (const std::int64_t vertex : group.vertices) ++count.at(static_cast<std::size_t>(vertex));
  }
  EXPECT_EQ(count, std::vector<int>(24, 1));
}

TEST_F(PushingConfig, StartsInTheSquareAndAimsAtTheOpening) {
  ASSERT_EQ(scene_.variation.size(), 2u);
  const auto& x = std::get<UniformDistribution>(scene_.variation[0].distribution);
  const auto& y = std::get<UniformDistribution>(scene_.variation[1].distribution);
  EXPECT_EQ(x.lower, -0.042);
  EXPECT_EQ(x.upper, 0.042);
  EXPECT_EQ(y.lower, 0.08);
  EXPECT_EQ(y.upper, 0.12);
  const Term& loss = scene_.loss.task.at(0);
  const auto& success = std::get<Within>(scene_.success->kind);
  EXPECT_EQ(loss.signals, success.signals);
  const SignalCrossing& aim = std::get<AtCrossing>(loss.when).crossing;
  const SignalCrossing& test = std::get<WhenCrossing>(success.when).crossing;
  EXPECT_EQ(aim.signal, test.signal);
  EXPECT_EQ(aim.at, test.at);
  EXPECT_EQ(std::get<NumberTarget>(loss.target).value, 0.0);
  EXPECT_EQ(loss.margin, 0.002);  // the loss aims inside the opening
  EXPECT_EQ(success.above, -0.008);
  EXPECT_EQ(success.below, 0.008);
}

}  // namespace pushing_config_test
}  // namespace knap
