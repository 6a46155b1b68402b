#include "sim/signals/depth_signals.h"

#include <Eigen/Dense>
#include <cstddef>
#include <optional>
#include <utility>

#include "sim/contact/deepest_place.h"
#include "sim/contact/moving_pieces.h"
#include "sim/signals/signal_frame.h"

namespace knap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

class DepthSignalFunction final : public SignalFunction {
 public:
  DepthSignalFunction(const std::vector<ContactPair>& contacts, std::vector<int> numbers)
      : numbers_(std::move(numbers)) {
    std::vector<ContactPair> own;
    for (const int number : numbers_) own.push_back(contacts[static_cast<std::size_t>(number)]);
    sides_ = MakeSides(own);
    for (const ContactSide& side : sides_) near_.emplace_back(side);
  }

  double Calc(const Moment& at) const override {
    if (at.track != nullptr) {
      if (const std::optional<double> depth = at.track->FindDepth(numbers_, at.state)) return *depth;
    }
    return Find(at).place.depth;
  }

  void PullBack(const Moment& at, double bar, SignalCotangents* out) const override {
    const Found found = Find(at);
    if (!(found.place.depth > 0.0)) return;
    const ContactSide& side = *found.side;
    const Pose& X_WB = GetKinematics(at, side.body).X_WB;
    const Pose& X_WS = GetKinematics(at, side.field_body).X_WB;
    const Vector3d g_W = bar * (X_WS.R * found.place.g_S);
    const Vector3d p_W = X_WS * found.place.p_S;
    AddForce(at, side.body, p_W, g_W, out);
    AddForce(at, side.field_body, p_W, -g_W, out);
    if (side.pieces) PullBackPlanes(found, bar, out);
    if (!side.is_designed) return;
    // The place keeps its barycentric coordinates as the facet's corners move.
    const int facet = found.place.facet;
    const Facet& triangle = side.facets->facets()[static_cast<std::size_t>(facet)];
    Matrix3d corners;
    for (int k = 0; k < 3; ++k) corners.col(k) << 1.0, triangle.corner[k];
    Vector3d place;
    place << 1.0, triangle.frame.Locate(X_WB.ApplyInverse(p_W));
    const Vector3d shares = corners.inverse() * place;
    const Vector3d g_B = X_WB.R.transpose() * g_W;
    for (int k = 0; k < 3; ++k) {
      out->vertices.push_back({numbers_[static_cast<std::size_t>(side.pair)], side.shape,
                               side.facets->triangles()[static_cast<std::size_t>(facet)][k], shares(k) * g_B});
    }
  }

 private:
  struct Found {
    const ContactSide* side = nullptr;
    DeepestPlace place;
  };

  Found Find(const Moment& at) const {
    Found found;
    for (std::size_t s = 0; s < sides_.size(); ++s) {
      const ContactSide& side = sides_[s];
      const Pose& X_WB = GetKinematics(at, side.body).X_WB;
      const Pose& X_WS = GetKinematics(at, side.field_body).X_WB;
      if (!near_[s].MayTouch(X_WB, X_WS)) continue;
      const Pose X_SB{X_WS.R.transpose() * X_WB.R, X_WS.ApplyInverse(X_WB.p)};
      const DeepestPlace place = FindDeepestPlace(side, X_SB, &near_[s], &scratch_);
      if (place.depth > found.place.depth) found = {&side, place};
    }
    return found;
  }

  // Of the planes that hold the place, to the vertices of their mesh.
  void PullBackPlanes(const Found& found, double bar, SignalCotangents* out) const {
    const ContactSide& side = *found.side;
    std::vector<FieldPlane> bar_planes(static_cast<std::size_t>(side.num_cells()), {Vector3d::Zero(), 0.0});
    for (std::size_t k = 0; k < found.place.planes.size(); ++k) {
      if (found.place.planes[k] < 0) continue;
      FieldPlane& plane = bar_planes[static_cast<std::size_t>(found.place.planes[k])];
      plane.d = bar * found.place.shares[k];
      plane.n = -plane.d * found.place.p_S;
    }
    Eigen::Matrix3Xd bar_vertices = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(side.pieces->vertices.size()));
    knap::PullBackPlanes(*side.pieces, side.piece, bar_planes, &bar_vertices);
    for (Eigen::Index i = 0; i < bar_vertices.cols(); ++i) {
      if (bar_vertices.col(i).isZero(0.0)) continue;
      out->vertices.push_back(
          {numbers_[static_cast<std::size_t>(side.pair)], 1 - side.shape, static_cast<int>(i), bar_vertices.col(i)});
    }
  }

  // As a force at a place would press on a body.
  static void AddForce(const Moment& at, int body, const Vector3d& p_W, const Vector3d& g_W, SignalCotangents* out) {
    StateCotangent& c = out->states.emplace_back();
    c.state = at.state;
    c.body = body;
    c.p_W = g_W;
    c.r_W = (p_W - GetKinematics(at, body).X_WB.p).cross(g_W);
  }

  std::vector<int> numbers_;
  std::vector<ContactSide> sides_;
  // What they remember changes no bit.
  mutable std::vector<NearFacets> near_;
  mutable SidePatches scratch_;
};

}  // namespace

std::unique_ptr<SignalFunction> MakeDepthSignal(const std::vector<ContactPair>& contacts, std::vector<int> numbers) {
  return std::make_unique<DepthSignalFunction>(contacts, std::move(numbers));
}

}  // namespace knap
