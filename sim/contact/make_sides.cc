#include "sim/contact/make_sides.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace knap {

using Eigen::Vector3d;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The core that a shape is when it is thinned by its own radius or rounding.
struct Core {
  Vector3d half;
  double radius;
  Vector3d center;
};

Core GetCore(const ContactGeometry& shape) {
  if (const auto* sphere = std::get_if<SphereGeometry>(&shape)) {
    return {Vector3d::Zero(), sphere->radius, sphere->center};
  }
  if (const auto* capsule = std::get_if<CapsuleGeometry>(&shape)) {
    return {Vector3d(0.0, 0.0, capsule->half_length), capsule->radius, capsule->center};
  }
  const BoxGeometry& box = std::get<BoxGeometry>(shape);
  return {box.half.array() - box.rounding, box.rounding, box.center};
}

double CalcLeastWidth(const ContactGeometry& shape) {
  if (const auto* capsule = std::get_if<CapsuleGeometry>(&shape)) return 2.0 * capsule->radius;
  return 2.0 * std::get<BoxGeometry>(shape).half.minCoeff();
}

// Balls that stand for a sphere, a capsule or a box. `spacing` infinite: ends and corners alone.
FeaturePoints MakeBalls(const ContactGeometry& shape, double spacing) {
  if (const auto* box = std::get_if<BoxGeometry>(&shape)) return MakeBoxFeatures(*box, box->rounding, spacing);
  if (const auto* capsule = std::get_if<CapsuleGeometry>(&shape)) return MakeCapsuleFeatures(*capsule, spacing);
  const SphereGeometry& sphere = std::get<SphereGeometry>(shape);
  return {{sphere.center}, {std::numbers::pi * sphere.radius * sphere.radius}, sphere.radius};
}

class SideMaker {
 public:
  explicit SideMaker(const std::vector<ContactPair>& contacts) {
    for (index_ = 0; index_ < static_cast<int>(contacts.size()); ++index_) Add(contacts[index_]);
  }
  std::vector<PointSide> sides;

 private:
  template <class T>
  static bool Is(const ContactGeometry& shape) {
    return std::holds_alternative<T>(shape);
  }

  void Add(const ContactPair& contact) {
    // The shape that stands first here touches with its points; half-spaces have none, then come meshes.
    const auto rank = [](const ContactGeometry& shape) {
      if (Is<SphereGeometry>(shape)) return 0;
      if (Is<CapsuleGeometry>(shape)) return 1;
      if (Is<BoxGeometry>(shape)) return 2;
      return Is<MeshGeometry>(shape) ? 3 : 4;
    };
    const int a = rank(contact.shapes[0]) <= rank(contact.shapes[1]) ? 0 : 1;
    const ContactGeometry& points = contact.shapes[a];
    const ContactGeometry& surface = contact.shapes[1 - a];
    if (Is<HalfSpaceGeometry>(points)) throw std::invalid_argument(Say("two half-spaces do not touch"));
    if (Is<MeshGeometry>(points) && Is<MeshGeometry>(surface)) {
      throw std::invalid_argument(Say("two meshes; one has to be a sphere, capsule, box or half-space"));
    }
    if (Is<HalfSpaceGeometry>(surface)) return AddOnHalfSpace(contact, a);
    if (Is<MeshGeometry>(surface)) return AddOnMesh(contact, a);
    if (Is<BoxGeometry>(points)) return AddBoxes(contact);
    // Balls against the core of the other shape, inflated by both radii.
    PointSide& side = Append(contact, a, 1.0);
    const Core core = GetCore(surface);
    side.features = MakeBalls(points, side_spacing(points, surface));
    side.rho = side.features.radius;
    if (Is<SphereGeometry>(points)) side.rolling_radius = side.rho;
    side.field = ShapeField::MakeRoundedCore(core.half, core.radius + side.rho, core.center);
    Number(&side);
  }

  static double side_spacing(const ContactGeometry& points, const ContactGeometry& surface) {
    if (Is<SphereGeometry>(points)) return kInfinity;
    const double other =
        Is<SphereGeometry>(surface) ? std::get<SphereGeometry>(surface).radius : 0.5 * CalcLeastWidth(surface);
    return std::min(0.5 * CalcLeastWidth(points), other);
  }

  void AddOnHalfSpace(const ContactPair& contact, int a) {
    const ContactGeometry& points = contact.shapes[a];
    PointSide& side = Append(contact, a, 1.0);
    if (Is<MeshGeometry>(points)) {
      side.point_mesh = std::get<MeshGeometry>(points).mesh;
      RequireSamples(*side.point_mesh);
      side.field = ShapeField::MakeHalfSpace(0.0);
    } else if (Is<SphereGeometry>(points)) {
      side.law = PointSide::Law::kSphereOnPlane;
      side.features = MakeBalls(points, kInfinity);
      side.rho = side.features.radius;
      side.rolling_radius = side.rho;
    } else {
      side.features = MakeBalls(points, kInfinity);
      side.rho = side.features.radius;
      side.field = ShapeField::MakeHalfSpace(side.rho);
    }
    Number(&side);
  }

  void AddOnMesh(const ContactPair& contact, int a) {
    const ContactGeometry& points = contact.shapes[a];
    const auto& mesh = std::get<MeshGeometry>(contact.shapes[1 - a]).mesh;
    if (Is<SphereGeometry>(points)) {
      PointSide& side = Append(contact, a, 1.0);
      side.law = PointSide::Law::kSphereOnMesh;
      side.surface_mesh = mesh;
      side.features = MakeBalls(points, kInfinity);
      side.rho = side.features.radius;
      side.rolling_radius = side.rho;
      Number(&side);
      return;
    }
    RequireSamples(*mesh);
    PointSide& features = Append(contact, a, 0.5);
    features.law = PointSide::Law::kBallOnMesh;
    features.surface_mesh = mesh;
    features.features = MakeBalls(points, CalcLeastWidth(points));
    features.rho = features.features.radius;
    Number(&features);
    PointSide& samples = Append(contact, 1 - a, 0.5);
    samples.point_mesh = mesh;
    const Core core = GetCore(points);
    if (const auto* box = std::get_if<BoxGeometry>(&points)) {
      samples.field = ShapeField::MakeSolidBox(box->half, box->rounding, box->center);
    } else {
      samples.field = ShapeField::MakeRoundedCore(core.half, core.radius, core.center);
    }
    Number(&samples);
  }

  void AddBoxes(const ContactPair& contact) {
    const double spacing = 0.5 * std::min(CalcLeastWidth(contact.shapes[0]), CalcLeastWidth(contact.shapes[1]));
    for (int a = 0; a < 2; ++a) {
      PointSide& side = Append(contact, a, 0.5);
      side.features = MakeBoxFeatures(std::get<BoxGeometry>(contact.shapes[a]), 0.0, spacing);
      const BoxGeometry& other = std::get<BoxGeometry>(contact.shapes[1 - a]);
      side.field = ShapeField::MakeSolidBox(other.half, other.rounding, other.center);
      Number(&side);
    }
  }

  PointSide& Append(const ContactPair& contact, int points_of, double share) {
    PointSide& side = sides.emplace_back();
    side.pair = index_;
    side.point_body = contact.bodies[points_of];
    side.surface_body = contact.bodies[1 - points_of];
    side.modulus = share * contact.material.stiffness;
    return side;
  }
  void Number(PointSide* side) {
    side->first_id = next_id_;
    next_id_ += static_cast<int>(side->points().size());
  }
  std::string Say(const std::string& what) const { return fmt::format("contact {}: {}", index_, what); }
  void RequireSamples(const ContactMesh& mesh) const {
    if (!mesh.has_samples()) throw std::invalid_argument(Say("the mesh has no samples"));
  }

  int index_ = 0;
  int next_id_ = 0;
};

}  // namespace

double CalcSampleSpacing(const ContactGeometry& against) {
  if (std::holds_alternative<CapsuleGeometry>(against) || std::holds_alternative<BoxGeometry>(against)) {
    return 0.5 * CalcLeastWidth(against);
  }
  return kInfinity;
}

std::vector<PointSide> MakeSides(const std::vector<ContactPair>& contacts) { return SideMaker(contacts).sides; }

}  // namespace knap
