// What a scenario file describes, as plain data, in three parts: the world, bodies on a tree of joints, contacts, the
// designed tool; the goal, what varies and how a rollout is integrated and judged; and the plan by which the tool is
// learned.
//
// All numbers are SI (m, kg, s, rad, N), whatever units the file used. scene_fields.h lists every field once with its
// key, unit, allowed range and default; a Scene that ParseScene returned without errors satisfies all that is said
// here.
//
// Frames: W world; P the parent body; J the joint frame, fixed in P; B the body frame, which the joint moves relative
// to J. At zero joint coordinates B coincides with J. Roll-pitch-yaw angles (r, p, y) mean R = Rz(y)·Ry(p)·Rx(r).
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim/scenarios/axis.h"
#include "sim/scenarios/controls.h"
#include "sim/scenarios/joint.h"
#include "sim/scenarios/objective.h"
#include "sim/scenarios/signals.h"

namespace knap {

// ---- Bodies -------------------------------------------------------------------------------------------------------

// Shapes are given in a frame G of their own, which a pose places in B.

// Solid below the plane z = 0 of G.
struct HalfSpaceShape {};

// Centred at Go.
struct SphereShape {
  double radius = 0.0;  // [m]
};

// A cylinder along Gz of the given length with half a sphere on either end, centred at Go.
struct CapsuleShape {
  double radius = 0.0;  // [m]
  double length = 0.0;  // between the centres of the half spheres [m]
};

// Along Gz, with flat ends, centred at Go.
struct CylinderShape {
  double radius = 0.0;  // [m]
  double length = 0.0;  // from end to end [m]
};

// A box along the axes of G, centred at Go; its edges and corners are rounded as made.
struct BoxShape {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // [m]
  double rounding = 0.0;                           // radius [m], at most half the least size
};

// A designed body: Scene::design gives its mesh, in B. At most one a body.
struct DesignedMeshShape {};

// A closed triangle mesh in G that stays as it is on file. One that is not convex touches as convex pieces.
struct MeshShape {
  std::string file;   // beside the scenario
  double unit = 0.0;  // length of one unit of the file [m]
};

using ShapeKind =
    std::variant<HalfSpaceShape, SphereShape, CapsuleShape, CylinderShape, BoxShape, DesignedMeshShape, MeshShape>;

struct Shape {
  ShapeKind kind;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();         // p_BG [m]; zero for a designed mesh
  Eigen::Vector3d orientation_rpy = Eigen::Vector3d::Zero();  // of G in B [rad]; likewise
};

// The body fills each of its shapes with one density, found from the total mass; where shapes overlap, twice.
struct SolidInertia {
  double mass = 0.0;  // [kg]
};

// The body fills each of its shapes with this density; the mass of a designed mesh follows the mesh.
struct DensityInertia {
  double density = 0.0;  // [kg/m³]
};

struct ExplicitInertia {
  double mass = 0.0;                                   // [kg]
  Eigen::Vector3d center = Eigen::Vector3d::Zero();    // p_BBcm_B [m]
  Eigen::Vector3d moments = Eigen::Vector3d::Zero();   // Ixx, Iyy, Izz of I_BBcm_B [kg·m²]
  Eigen::Vector3d products = Eigen::Vector3d::Zero();  // Ixy, Ixz, Iyz of I_BBcm_B, its off-diagonal entries
};

using Inertia = std::variant<SolidInertia, DensityInertia, ExplicitInertia>;

inline constexpr char kWorldName[] = "world";

struct Body {
  std::string name;
  std::string parent = kWorldName;  // "world" or the name of another body; the bodies form a tree, in any order
  Joint joint;
  std::vector<Shape> shapes;       // what touches
  std::optional<Inertia> inertia;  // present at least wherever the joint is neither fixed nor prescribed
};

// ---- Ropes --------------------------------------------------------------------------------------------------------

// A square helix about an axis along Wx: each side of the square is `links_per_side` links long, and the helix is
// centred at `center`. The first link runs along −Wy, above the axis; from one side to the next it turns about Wx.
struct HelixState {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  // in W [m]
  std::int64_t links_per_side = 1;
  double advance = 0.0;  // along Wx, a turn [m]
  double turn = 0.0;     // of the whole about its axis [rad]
};

// Straight, from its first joint on.
struct StraightState {
  Eigen::Vector3d start = Eigen::Vector3d::Zero();       // in W [m]
  Eigen::Vector3d direction = Eigen::Vector3d::UnitY();  // in W, not zero, of any length
};

using RopeState = std::variant<HelixState, StraightState>;

// Boxes of square section on ball joints, one after another, with both ends free. Link i is the body that turns about
// joint i; its x axis leads to joint i + 1, and its box lies between the two with half the gap at either end.
struct Rope {
  std::string name;
  std::int64_t links = 1;
  double pitch = 0.0;          // from joint to joint [m]
  double thickness = 0.0;      // side of the section [m]
  double gap = 0.0;            // between the boxes of a straight rope [m], less than the pitch
  double rounding = 0.0;       // of the boxes [m], at most half their least size
  double link_mass = 0.0;      // [kg], spread evenly over the box
  double joint_damping = 0.0;  // [N·m·s/rad]
  RopeState initial;           // at rest
};

// ---- Contact ------------------------------------------------------------------------------------------------------

// Between all shapes of two bodies, or all links of a rope; a rope with itself: each two of its links that are no
// neighbours.
struct Contact {
  std::array<std::string, 2> bodies;  // two different bodies, each with shapes, or ropes
  double stiffness = 0.0;             // pressure per depth [N/m³]
  double damping = 0.0;               // of the normal force, relative to it: Hunt and Crossley's [s/m]
  double friction = 0.0;              // Coulomb's μ [-]
  double rolling_resistance = 0.0;    // r in the torque r·radius·N against rolling [-]
  double slip_speed = 1e-3;           // speed at which friction is fully developed [m/s]
  double stick_distance = 0.0;        // by which a sticking point gives way; 0: slip_speed alone counts [m]
};

// ---- Grips --------------------------------------------------------------------------------------------------------

// A spring with damping between a point of a body and one of another body or of a rope, for a time
// (sim/contact/grip.h).
struct Grip {
  std::string body;                                      // that holds
  Eigen::Vector3d point = Eigen::Vector3d::Zero();       // in B [m]; moves with the mesh of a designed body
  std::string held;                                      // a body or a rope, other than `body`
  Eigen::Vector3d held_point = Eigen::Vector3d::Zero();  // likewise; of a rope: along it from its first joint, across
  double stiffness = 0.0;                                // [N/m]
  double damping = 0.0;                                  // [N·s/m]
  double limit = 0.0;                                    // most that the spring pulls with [N]; 0: none
  double from = 0.0;                                     // [s]
  double until = 0.0;                                    // > from [s]
};

// ---- Design -------------------------------------------------------------------------------------------------------

// What a parameter's change does to the cage vertices of a group (CageMove).
enum class ParameterKind {
  kShift,    // [m]: shifts them by change·direction
  kStretch,  // [-]: stretches them about Bo, coordinate by coordinate: c_i += change·direction_i·c_i, c as on file
};

struct DesignParameter {
  std::string name;
  ParameterKind kind = ParameterKind::kShift;
  double initial = 0.0;  // lower ≤ initial ≤ upper, lower < upper
  double lower = 0.0;
  double upper = 0.0;
};

struct VertexBox {
  Eigen::Vector3d lower = Eigen::Vector3d::Zero(), upper = Eigen::Vector3d::Zero();  // in B [m]
};

// The half space of the points p with normal·(p − point) ≥ 0.
struct VertexPlane {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   // in B [m]
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // in B, of any length but zero
};

// Chosen in one of three ways (vertex_groups.h).
struct VertexGroup {
  std::string name;
  std::vector<std::int64_t> vertices;  // of the cage, counted from 0, each at most once
  std::optional<VertexBox> box{};
  std::optional<VertexPlane> plane{};
};

// Moves every vertex of the group as its parameter's kind says.
struct CageMove {
  std::string parameter;
  std::string group;                                    // of the same body
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // in B [-]
};

// A body with a designed mesh: cage = cage on file + Σ moves. What hangs on the body moves along with the
// mesh as a point of it would, through the cage's mean value coordinates: the joints that it carries (by their
// attachment points), and the points that losses watch.
struct DesignedBody {
  std::string name;         // of the body
  std::string mesh;         // file, relative to the scenario's
  std::string cage;         // file, relative to the scenario's
  double mesh_unit = 1e-3;  // length of one unit of both files [m]
  double refine = 0.0;      // longest edge of the mesh, whose triangles are split [m]; 0: as on file
  std::vector<VertexGroup> vertex_groups;
  std::vector<CageMove> moves;  // none: the mesh is as on file
};

struct Design {
  std::vector<DesignParameter> parameters;  // theta
  std::vector<DesignedBody> bodies;         // each at most once
};

// ---- Variation ----------------------------------------------------------------------------------------------------

struct UniformDistribution {
  double lower = 0.0;
  double upper = 0.0;  // ≥ lower
};

// Normal, conditioned on |x − mean| ≤ truncate_at·std.
struct NormalDistribution {
  double mean = 0.0;
  double std = 0.0;
  double truncate_at = 3.0;  // [-]
};

// The logarithm is uniform.
struct LogUniformDistribution {
  double lower = 1.0;  // > 0
  double upper = 1.0;  // ≥ lower
};

// One of these, each as likely.
struct ChoiceDistribution {
  std::vector<double> values;  // at least one
};

// Of several numbers together.

// A point of a disc or ball, each place as likely.
struct DiscDistribution {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double radius = 0.0;  // ≥ 0
};
struct BallDistribution {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius = 0.0;  // ≥ 0
};

// The roll-pitch-yaw angles of an orientation: every one as likely; or a turn about an axis, the angle uniform [rad].
struct OrientationDistribution {};
struct TurnDistribution {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  // not zero
  double lower = 0.0;
  double upper = 0.0;  // ≥ lower
};

// Normal with these correlations, each number within truncate_at standard deviations of its mean.
struct CorrelatedDistribution {
  std::vector<double> mean, std;    // one each
  std::vector<double> correlation;  // of each pair, row by row above the diagonal: 12, 13, …, 23, … [-]
  double truncate_at = 3.0;         // [-]
};

// Symmetric, with ones on its diagonal.
Eigen::MatrixXd MakeCorrelationMatrix(const CorrelatedDistribution& distribution);

// A row of a file of numbers in SI units, each as likely; columns are named by the keys.
struct TableDistribution {
  std::string file;  // CSV, relative to the scenario's
};

using Distribution = std::variant<UniformDistribution, NormalDistribution, LogUniformDistribution, ChoiceDistribution,
                                  DiscDistribution, BallDistribution, OrientationDistribution, TurnDistribution,
                                  CorrelatedDistribution, TableDistribution>;

// Numbers of the scene that differ between rollouts; every value that can be drawn is allowed for its key. Those of one
// entry are drawn together, those of different entries independently.
struct Variation {
  std::vector<std::string> keys;  // e.g. "bodies.pea.initial.position[0]", see numeric_keys.h
  Distribution distribution;      // in the SI unit of the keys
};

// Of all entries, in their order: what a rollout is given values for.
std::vector<std::string> ListVariedKeys(const std::vector<Variation>& variation);

// ---- Perturbation --------------------------------------------------------------------------------------------------

// How the start of a free body or of a rope differs. A body that the world carries moves on the level, along what is
// level of Wx and across that, and turns about the vertical through Bo; a straight rope moves along itself and across,
// along the y axis of its links, and turns about their z axis at its first joint; a helix moves along its axis alone
// and turns about it. These are the moves that press none of them into what it lies on.
struct StartPerturbation {
  std::string name;
  double along = 0.0;   // [m]
  double across = 0.0;  // [m]; 0 for a helix
  double turn = 0.0;    // [rad]
};

// How the scene differs from what the rest of the file says: friction of all contacts, masses and inertias of all that
// forces move, and the speed at which prescribed motions and with them all times of the scene pass are so many times
// as large (sim/rollout/perturb_scene.h). Numbers to be varied; none of it says anything of design or learning.
struct Perturbation {
  double friction = 1.0;
  double mass = 1.0;
  double speed = 1.0;
  std::vector<StartPerturbation> starts;
};

// ---- Rollout ------------------------------------------------------------------------------------------------------

enum class Integrator { kTrBdf2, kBdf1, kBdf2 };

struct Rollout {
  double horizon = 0.0;  // [s]
  double step = 0.0;     // [s]; the horizon is a whole number of steps. TR-BDF2: the longest
  Integrator integrator = Integrator::kTrBdf2;
  double tolerance = 1e-3;          // of TR-BDF2: on the scaled error of a step [-]
  double newton_tolerance = 1e-12;  // on the scaled residual [-]
  std::int64_t newton_max_iterations = 30;
};

// ---- Learning -----------------------------------------------------------------------------------------------------

// What learning moves.
enum class LearnedPart { kDesign, kControl, kPolicy };

enum class SceneLearningMethod { kOurs, kSimpleContinual, kDiffHand };

// Which design is what was learned: the best validated one, or the last.
enum class Keep { kBest, kLast };

struct Learning {
  SceneLearningMethod method = SceneLearningMethod::kOurs;
  std::vector<LearnedPart> optimize = {LearnedPart::kDesign};  // each at most once; the rest stays initial
  std::int64_t variations = 100;                               // N; 1 in a scene that does not vary
  std::int64_t batch = 5;                                      // M, ≤ N
  std::int64_t dimensions_per_batch = 2;                       // d', ≤ d where there is a design
  double alpha = 0.1;                                          // weight of the distillation loss [-]
  double learning_rate = 0.25;         // box radius, as a fraction of each parameter's range [-]
  double decay = 0.36787944117144233;  // of the learning rate at each restart: e⁻¹ [-]
  std::string optimizer = "LD_LBFGS";  // NLopt's or an evolution strategy
  std::int64_t max_evaluations = 15;   // of the optimizer, a batch
  double loss_tolerance = 1e-4;        // relative change of a batch's loss at which it ends [-]
  double parameter_tolerance = 1e-4;   // likewise of every parameter, as a fraction of its range [-]
  std::int64_t rollout_budget = 0;     // of the whole learning; 0: none
  std::int64_t validation = 20;  // variations on which designs are compared; 0: none; 0 in a scene that does not vary
  Keep keep = Keep::kBest;
  std::int64_t seed = 0;
  // Where learning starts, one value a parameter in the problem's order, SI; empty: at the initial ones.
  std::vector<double> start{};
};

struct Evaluation {
  std::int64_t variations = 200;  // 1 in a scene that does not vary
  std::int64_t seed = 1;
};

enum class GradientComparison { kNone, kFiner };

// What the rollouts' gradients are held to.
struct GradientDemand {
  double tolerance = 1e-5;  // relative to ‖g‖∞ in range-normalised parameters
  double step = 5e-7;       // of a range, over which rounding must not hide that much
  double loss_error = 0.1;  // share of ‖g‖∞: what chosen steps may do to the loss
  double touchdown = 0.1;   // share of ‖g‖ by which it may differ from that at frozen time nodes, after a cascade
  GradientComparison compare = GradientComparison::kNone;
  double change = 0.08;   // share of ‖g‖ by which it may differ from that at a quarter of the tolerance
  double flagged = 0.05;  // share of rollouts whose own certificate may warn
};

// What rollouts are held to: one that is not is not to be trusted, and no success.
struct TrustDemand {
  double penetration = 0.5;  // of the depth that the thinner of two bodies, or the field of a round one, has
};

// ---- The whole ----------------------------------------------------------------------------------------------------

// 1 had one shape a body, and losses, success tests and observations of its own kinds: docs/migrating.md.
inline constexpr std::int64_t kSceneSchema = 2;

// Where down is.
struct GravityDirection {
  double azimuth = 0.0;  // about Wz, from Wx [rad]
  double rise = -1.0;    // its z component; uniform over [−1, 1], with a uniform azimuth: uniform over all directions
};

// What there is: bodies and what acts between them, what of it has a name, what is shaped and what drives it.
struct World {
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};           // in W [m/s²]
  std::optional<GravityDirection> gravity_direction;  // turns gravity, of which only the size counts then
  std::vector<Body> bodies;
  std::vector<Rope> ropes;
  std::vector<Contact> contacts;
  std::vector<Grip> grips;
  std::vector<Signal> signals;
  std::optional<Design> design;      // none: no design parameters
  std::optional<Controls> controls;  // none: nothing is driven open loop
  std::optional<Policy> policy;      // none: nothing is driven in a closed loop; else no actuator that controls drive
  std::optional<Perturbation> perturbation;  // none: the world as it is

  bool IsDriven() const { return controls || policy; }
};

// What is wanted of it: what differs between rollouts, how each is simulated, judged and trusted.
struct Goal {
  std::vector<Variation> variation;
  Rollout rollout;
  Loss loss;
  std::optional<Condition> success;  // none: nothing is called failed
  GradientDemand gradient;
  TrustDemand trust;
};

// How it is learned: nothing of this changes a rollout, and answers are kept under what the other two say.
struct Plan {
  Learning learning;
  Evaluation evaluation;
};

// Three documents in one file.
struct Scene : World, Goal, Plan {
  std::int64_t schema = kSceneSchema;
  std::string name;
  std::string description;
};

}  // namespace knap
