#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <variant>

#include "coordinator/report/picture.h"
#include "coordinator/report/rope_view.h"
#include "coordinator/report/svg_ink.h"

namespace knap {
namespace {

constexpr std::uint64_t kColumns = 3;
constexpr double kPanel = 300.0, kGap = 16.0, kMargin = 30.0, kRowTitle = 44.0, kLegendHeight = 48.0;  // [px]
constexpr double kShown = 0.12;  // to either side of the tool's origin [m]

struct Tint {
  Eigen::Vector3d dark, bright;  // red, green, blue; 0 … 255
};
const Tint kGrey{{87, 96, 106}, {208, 215, 222}};
const Tint kBlue{{5, 80, 174}, {128, 190, 255}};
const Tint kRope{{122, 62, 0}, {255, 190, 92}};

std::string FormatColour(const Tint& tint, double light) {
  const Eigen::Vector3d c = tint.dark + light * (tint.bright - tint.dark);
  return fmt::format("#{:02x}{:02x}{:02x}", std::lround(c.x()), std::lround(c.y()), std::lround(c.z()));
}

// Neighbours in depth of one colour become one path.
std::string DrawFaces(const std::vector<ShownFace>& faces, const Tint& tool, const PanelMap& map) {
  std::string ink, data, colour;
  const auto flush = [&] {
    if (!data.empty()) ink += fmt::format("<path d=\"{}\" fill=\"{}\" stroke=\"{}\"/>\n", data, colour, colour);
    data.clear();
  };
  for (const ShownFace& face : faces) {
    const std::string now = FormatColour(face.of_rope ? kRope : tool, face.light);
    if (now != colour) flush();
    colour = now;
    data += DrawPoints(face.corners, map) + "Z";
  }
  flush();
  return "<g stroke-width=\"0.5\" stroke-linejoin=\"round\">\n" + ink + "</g>\n";
}

const Rope* FindShownRope(const Scene& scene) {
  if (!scene.success || !scene.design || scene.design->bodies.size() != 1 || scene.IsDriven()) return nullptr;
  const auto* test = std::get_if<HoldsRope>(&*scene.success);
  if (test == nullptr || test->body != scene.design->bodies[0].name) return nullptr;
  const auto found =
      std::find_if(scene.ropes.begin(), scene.ropes.end(), [&](const Rope& r) { return r.name == test->rope; });
  return found == scene.ropes.end() ? nullptr : &*found;
}

}  // namespace

std::optional<std::string> DrawRopeView(RolloutModel& model, const VariationSpec& variations,
                                        const PictureFigures& figures) {
  const Rope* rope = FindShownRope(model.scene());
  if (rope == nullptr) return std::nullopt;
  PanelMap map;
  map.shown = {Eigen::Vector2d::Constant(-kShown), Eigen::Vector2d::Constant(kShown)};
  map.scale = 0.5 * kPanel / kShown;
  const double width = 2.0 * kMargin + kColumns * kPanel + (kColumns - 1) * kGap;
  const double height = 3.0 * (kRowTitle + kPanel) + kLegendHeight;
  std::string svg = BeginSvg(width, height);
  const auto title = [&](int row, const std::string& text) {
    svg += DrawText({0.5 * width, row * (kRowTitle + kPanel) + 30.0}, 20, "middle", kInk, text, "bold");
  };
  const double end = model.scene().rollout.horizon;
  title(0, "Three starts");
  title(1, fmt::format("{} after {} s", FormatTitle("Initial", figures.test_initial, "held"), end));
  title(2, fmt::format("{} after {} s", FormatTitle("Learned", figures.test_learned, "held"), end));
  for (std::uint64_t column = 0; column < kColumns; ++column) {
    const std::vector<double> variation =
        SampleVariation(variations, figures.test_initial.seed, RandomStream::kTestVariations, column);
    const auto panel = [&](int row, const TriangleMesh& tool, const Recording& seen, std::size_t k, const Tint& tint,
                           const char* border) {
      std::vector<Pose> X_WL;
      for (std::int64_t i = 0; i < rope->links; ++i) {
        X_WL.push_back(seen.Find(fmt::format("{} link {}", rope->name, i)).X_WB[k]);
      }
      map.corner = {kMargin + column * (kPanel + kGap), row * (kRowTitle + kPanel) + kRowTitle};
      svg += BeginPanel(3 * row + static_cast<int>(column), map.corner, {kPanel, kPanel}, border);
      svg += DrawFaces(CalcShownFaces(tool, X_WL, *rope, CalcEye(seen.gravity_W)), tint, map) + "</g>\n";
    };
    const auto at_end = [&](int row, const Eigen::VectorXd& theta, const Tint& tint) {
      const RecordedRollout rollout = model.Record({theta, {}, variation}, end);
      const Recording& seen = rollout.recording;
      const TriangleMesh tool = model.design()->Find(model.design()->bodies().front())->CalcMesh(theta);
      if (row == 1) panel(0, tool, seen, 0, tint, kFrame);
      panel(row, tool, seen, seen.time.size() - 1, tint, rollout.output.success ? kSuccess : kFailure);
    };
    at_end(1, model.design()->initial_theta(), kGrey);
    at_end(2, Eigen::Map<const Eigen::VectorXd>(figures.learned.data(), model.num_parameters()), kBlue);
  }
  svg += DrawText({kMargin, height - 18.0}, 16, "start", kFaint, "Gravity points down; green: held, red: lost");
  svg += DrawScaleBar({width - kMargin, height - 18.0}, map, 0.05);
  return svg + "</svg>\n";
}

}  // namespace knap
