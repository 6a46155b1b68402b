#include "sim/scenarios/scene_fields.h"

#include <type_traits>

#include "sim/scenarios/common_fields.h"
#include "sim/scenarios/control_fields.h"
#include "sim/scenarios/joint_fields.h"
#include "sim/scenarios/objective_fields.h"
#include "sim/scenarios/rollout_fields.h"
#include "sim/scenarios/variation_fields.h"

namespace knap {
namespace {

using std::string_view;

constexpr Range kIndex{0.0, 1e9};
constexpr Range kRolloutCount{1.0, 1e6};  // of rollouts that are asked for together, or of such rounds

// Of the values of a parameter.
Dimension GetDimension(ParameterKind kind) { return kind == ParameterKind::kStretch ? kDimensionless : kLength; }

}  // namespace

// ---- Bodies -------------------------------------------------------------------------------------------------------

static void VisitFields(FieldVisitor&, HalfSpaceShape&) {}

static void VisitFields(FieldVisitor& v, SphereShape& s) {
  v.Number({.key = "radius", .doc = "of the sphere", .dimension = kLength, .range = kPositive}, s.radius);
}

static void VisitFields(FieldVisitor& v, CapsuleShape& s) {
  v.Number({.key = "radius", .doc = "of the cylinder and its round ends", .dimension = kLength, .range = kPositive},
           s.radius);
  v.Number({.key = "length", .doc = "of the cylinder, along z", .dimension = kLength, .range = kPositive}, s.length);
}

static void VisitFields(FieldVisitor& v, CylinderShape& s) {
  v.Number({.key = "radius", .doc = "of the flat ends", .dimension = kLength, .range = kPositive}, s.radius);
  v.Number({.key = "length", .doc = "from end to end, along z", .dimension = kLength, .range = kPositive}, s.length);
}

static void VisitFields(FieldVisitor& v, BoxShape& s) {
  v.Numbers({.key = "size", .doc = "along x, y, z", .dimension = kLength, .range = kPositive}, s.size);
  v.Number({.key = "rounding",
            .doc = "radius of edges and corners as made, at most half the least size; contact takes them as sharp",
            .required = false,
            .dimension = kLength,
            .range = kNonNegative},
           s.rounding);
}

static void VisitFields(FieldVisitor&, DesignedMeshShape&) {}

static void VisitFields(FieldVisitor& v, MeshShape& s) {
  v.Text({.key = "file",
          .doc = "closed triangle mesh; one that is not convex touches as convex pieces",
          .role = TextRole::kFile},
         s.file);
  v.Number({.key = "unit",
            .doc = "length of one unit of the file",
            .dimension = kLength,
            .range = kPositive,
            .read_once = true},
           s.unit);
}

// Meshes are placed when they are read.
static void VisitPose(FieldVisitor& v, bool read_once, Shape& s) {
  v.Numbers({.key = "position", .doc = "in B", .required = false, .dimension = kLength, .read_once = read_once},
            s.position);
  v.Numbers({.key = "orientation_rpy",
             .doc = "in B: roll, pitch, yaw",
             .required = false,
             .dimension = kAngle,
             .read_once = read_once},
            s.orientation_rpy);
}

static void VisitFields(FieldVisitor& v, Shape& s) {
  v.OneOf({.key = "type",
           .doc = "half_space: solid below z = 0; designed_mesh: see `design`, it lies in B as its file has it; mesh: "
                  "stays as it is on file"},
          s.kind, {"half_space", "sphere", "capsule", "cylinder", "box", "designed_mesh", "mesh"},
          [&s](FieldVisitor& w, auto& kind) {
            using Kind = std::decay_t<decltype(kind)>;
            VisitFields(w, kind);
            if constexpr (!std::is_same_v<Kind, DesignedMeshShape>) VisitPose(w, std::is_same_v<Kind, MeshShape>, s);
          });
}

static void VisitFields(FieldVisitor& v, SolidInertia& i) {
  v.Number({.key = "mass",
            .doc = "spread evenly over the body's shapes; what two of them share counts twice",
            .dimension = kMass,
            .range = kPositive},
           i.mass);
}

static void VisitFields(FieldVisitor& v, DensityInertia& i) {
  v.Number({.key = "density", .doc = "all over each of the body's shapes", .dimension = kDensity, .range = kPositive},
           i.density);
}

static void VisitFields(FieldVisitor& v, ExplicitInertia& i) {
  v.Number({.key = "mass", .doc = "of the body", .dimension = kMass, .range = kPositive}, i.mass);
  VisitVector(v, "center", "centre of mass in B", kLength, i.center);
  v.Numbers({.key = "moments",
             .doc = "Ixx, Iyy, Izz about the centre of mass, in B",
             .dimension = kRotationalInertia,
             .range = kPositive},
            i.moments);
  VisitVector(v, "products", "Ixy, Ixz, Iyz about the centre of mass: the entries off the diagonal", kRotationalInertia,
              i.products);
}

static void VisitFields(FieldVisitor& v, Inertia& inertia) {
  v.OneOf({.key = "type", .doc = "solid and density: the sum over the body's shapes"}, inertia,
          {"solid", "density", "explicit"});
}

static void VisitFields(FieldVisitor& v, Body& b) {
  v.Text({.key = "name", .doc = "of the body", .role = TextRole::kNewBody}, b.name);
  v.Text({.key = "parent",
          .doc = "`world` or the body that carries the joint",
          .required = false,
          .role = TextRole::kBodyOrWorld},
         b.parent);
  v.Struct({.key = "joint", .doc = "to the parent"}, b.joint);
  v.StructList({.key = "shapes", .doc = "what touches", .required = false}, b.shapes);
  v.OptionalStruct(
      {.key = "inertia", .doc = "needed where the joint is neither fixed nor prescribed", .required = false},
      b.inertia);
  VisitInitialState(v, b.joint.kind);
}

// ---- Ropes --------------------------------------------------------------------------------------------------------

static void VisitFields(FieldVisitor& v, HelixState& h) {
  VisitVector(v, "center", "in the world", kLength, h.center);
  v.Integer({.key = "links_per_side", .doc = "of the square, around an axis along x", .range = kCount},
            h.links_per_side);
  v.Number({.key = "advance", .doc = "along x, a turn", .dimension = kLength}, h.advance);
  v.Number({.key = "turn", .doc = "of the whole about its axis", .required = false, .dimension = kAngle}, h.turn);
}

static void VisitFields(FieldVisitor& v, StraightState& s) {
  VisitVector(v, "start", "of its first joint in the world", kLength, s.start);
  v.Numbers({.key = "direction", .doc = "in the world, of any length but zero"}, s.direction);
}

static void VisitFields(FieldVisitor& v, RopeState& state) {
  v.OneOf({.key = "type", .doc = "helix: wound squarely; straight"}, state, {"helix", "straight"});
}

static void VisitFields(FieldVisitor& v, Rope& r) {
  v.Text({.key = "name", .doc = "of the rope", .role = TextRole::kNewRope}, r.name);
  v.Integer({.key = "links", .doc = "boxes on ball joints", .range = {1.0, 10000.0}}, r.links);
  v.Number({.key = "pitch", .doc = "from joint to joint", .dimension = kLength, .range = kPositive}, r.pitch);
  v.Number({.key = "thickness", .doc = "side of the square section", .dimension = kLength, .range = kPositive},
           r.thickness);
  v.Number({.key = "gap",
            .doc = "between the boxes of a straight rope",
            .required = false,
            .dimension = kLength,
            .range = kNonNegative},
           r.gap);
  v.Number({.key = "rounding",
            .doc = "radius of edges and corners as made, at most half the least size; contact takes them as sharp",
            .required = false,
            .dimension = kLength,
            .range = kNonNegative},
           r.rounding);
  v.Number({.key = "link_mass", .doc = "of each box", .dimension = kMass, .range = kPositive}, r.link_mass);
  v.Number({.key = "joint_damping",
            .doc = "torque per angular speed",
            .required = false,
            .dimension = kAngularDamping,
            .range = kNonNegative},
           r.joint_damping);
  v.Struct({.key = "initial", .doc = "how it lies at time 0, at rest"}, r.initial);
}

// ---- Contact ------------------------------------------------------------------------------------------------------

static void VisitFields(FieldVisitor& v, Contact& c) {
  v.FixedList({.key = "bodies", .doc = "the two that touch; a rope twice: its own links"}, c.bodies,
              [](FieldVisitor& w, std::string& name) { w.Text({.role = TextRole::kBodyOrRope}, name); });
  v.Number({.key = "stiffness", .doc = "pressure per depth", .dimension = kContactStiffness, .range = kPositive},
           c.stiffness);
  v.Number({.key = "damping",
            .doc = "of the normal force, relative to it (Hunt and Crossley)",
            .required = false,
            .dimension = kContactDamping,
            .range = kNonNegative},
           c.damping);
  v.Number({.key = "friction", .doc = "Coulomb's coefficient", .required = false, .range = {0.0, 10.0}}, c.friction);
  v.Number({.key = "rolling_resistance", .doc = "r in the torque r·radius·N", .required = false, .range = {0.0, 1.0}},
           c.rolling_resistance);
  v.Number({.key = "slip_speed",
            .doc = "at which friction is fully developed",
            .required = false,
            .dimension = kSpeed,
            .range = kPositive},
           c.slip_speed);
  v.Number({.key = "stick_distance",
            .doc = "by which a sticking point gives way without creeping; 0: friction follows slip_speed alone",
            .required = false,
            .dimension = kLength,
            .range = kNonNegative},
           c.stick_distance);
}

// ---- Grips --------------------------------------------------------------------------------------------------------

static void VisitFields(FieldVisitor& v, Grip& g) {
  v.Text({.key = "body", .doc = "that holds", .role = TextRole::kBody}, g.body);
  VisitVector(v, "point", "in the body; on a designed body it moves with the mesh", kLength, g.point);
  v.Text({.key = "held", .doc = "that is held", .role = TextRole::kBodyOrRope}, g.held);
  VisitVector(v, "held_point", "in the held body, likewise; of a rope: x along it from its first joint, y and z across",
              kLength, g.held_point);
  v.Number(
      {.key = "stiffness", .doc = "of a spring from point to point", .dimension = kLinearStiffness, .range = kPositive},
      g.stiffness);
  v.Number({.key = "damping",
            .doc = "force per speed of the held point as the holding body sees it",
            .required = false,
            .dimension = kLinearDamping,
            .range = kNonNegative},
           g.damping);
  v.Number({.key = "limit",
            .doc = "F: pulls with k d/sqrt(1 + (k d/F)^2), from afar with F; 0: a linear spring",
            .required = false,
            .dimension = kForceDimension,
            .range = kNonNegative},
           g.limit);
  v.Number(
      {.key = "from", .doc = "time from which it holds", .required = false, .dimension = kTime, .range = kNonNegative},
      g.from);
  v.Number({.key = "until", .doc = "time at which it lets go", .dimension = kTime, .range = kPositive}, g.until);
}

// ---- Design -------------------------------------------------------------------------------------------------------

static void VisitFields(FieldVisitor& v, DesignParameter& p) {
  v.Text({.key = "name", .doc = "of the parameter", .role = TextRole::kNewParameter}, p.name);
  static constexpr string_view kKinds[] = {"length", "scale"};
  v.EnumField({.key = "kind",
               .doc = "length: shifts vertices; scale: stretches them about Bo; its values are numbers without unit",
               .required = false},
              p.kind, kKinds);
  const Dimension dimension = GetDimension(p.kind);
  v.Number({.key = "initial", .doc = "value of mesh and cage as they are on file", .dimension = dimension}, p.initial);
  v.Number({.key = "lower", .doc = "least value", .dimension = dimension}, p.lower);
  v.Number({.key = "upper", .doc = "largest value", .dimension = dimension}, p.upper);
}

static void VisitFields(FieldVisitor& v, VertexBox& b) {
  v.Numbers({.key = "lower", .doc = "least coordinates in B, which count as inside", .dimension = kLength}, b.lower);
  v.Numbers({.key = "upper", .doc = "largest ones, likewise", .dimension = kLength}, b.upper);
}

static void VisitFields(FieldVisitor& v, VertexPlane& p) {
  v.Numbers({.key = "point", .doc = "of the plane, in B; what lies on it counts", .dimension = kLength}, p.point);
  v.Numbers({.key = "normal", .doc = "towards the vertices that count, of any length but zero"}, p.normal);
}

static void VisitFields(FieldVisitor& v, VertexGroup& g) {
  v.Text({.key = "name", .doc = "of the group", .role = TextRole::kNewGroup}, g.name);
  v.LeafList({.key = "vertices", .doc = "of the cage, counted from 0", .required = false}, g.vertices, 0,
             [](FieldVisitor& w, std::int64_t& i) { w.Integer({.range = kIndex}, i); });
  v.OptionalStruct({.key = "box", .doc = "in place of `vertices`: those of the cage that lie in it", .required = false},
                   g.box);
  v.OptionalStruct(
      {.key = "plane", .doc = "in place of `vertices`: those of the cage on its normal's side", .required = false},
      g.plane);
}

static void VisitFields(FieldVisitor& v, CageMove& m) {
  v.Text({.key = "parameter", .doc = "that moves", .role = TextRole::kParameter}, m.parameter);
  v.Text({.key = "group", .doc = "that is moved, of the same body", .role = TextRole::kGroup}, m.group);
  v.Numbers({.key = "direction",
             .doc = "d in B: length shifts vertices by change·d, scale by change·d_i·c_i, c the vertex on file"},
            m.direction);
}

static void VisitFields(FieldVisitor& v, DesignedBody& b) {
  v.Text({.key = "name", .doc = "of the body, whose shape is a designed mesh", .role = TextRole::kBody}, b.name);
  v.Text({.key = "mesh", .doc = "closed triangle mesh in B", .role = TextRole::kFile}, b.mesh);
  v.Text({.key = "cage", .doc = "closed triangle mesh around it, in B", .role = TextRole::kFile}, b.cage);
  v.Number({.key = "mesh_unit", .doc = "length of one unit of both files", .dimension = kLength, .range = kPositive},
           b.mesh_unit);
  v.Number({.key = "refine",
            .doc = "longest edge: triangles of the mesh with longer ones are split, so that it bends with its cage; "
                   "0: as on file",
            .required = false,
            .dimension = kLength,
            .range = kNonNegative},
           b.refine);
  v.StructList({.key = "vertex_groups", .doc = "named sets of cage vertices", .required = false}, b.vertex_groups);
  v.StructList(
      {.key = "moves", .doc = "cage = cage on file + what the parameters' changes do to it", .required = false},
      b.moves);
}

static void VisitFields(FieldVisitor& v, Design& d) {
  v.StructList({.key = "parameters", .doc = "theta, in the order of its components"}, d.parameters, 1);
  v.StructList({.key = "bodies", .doc = "whose meshes it shapes; joints and watched points on them move along"},
               d.bodies, 1);
}

// ---- Perturbation --------------------------------------------------------------------------------------------------

static void VisitFields(FieldVisitor& v, StartPerturbation& s) {
  v.Text({.key = "name", .doc = "of a free body that the world carries, or of a rope", .role = TextRole::kBodyOrRope},
         s.name);
  v.Number({.key = "along",
            .doc = "a body: on the level, along x; a rope: along itself; a helix: along its axis",
            .required = false,
            .dimension = kLength},
           s.along);
  v.Number({.key = "across", .doc = "at right angles to that; 0 for a helix", .required = false, .dimension = kLength},
           s.across);
  v.Number({.key = "turn",
            .doc = "a body: about the vertical; a rope: about its links' z axis; a helix: about its axis",
            .required = false,
            .dimension = kAngle},
           s.turn);
}

static void VisitFields(FieldVisitor& v, Perturbation& p) {
  static constexpr Range kFactor{0.1, 10.0};
  v.Number({.key = "friction", .doc = "of all contacts, times that", .required = false, .range = kFactor}, p.friction);
  v.Number({.key = "mass", .doc = "of all bodies and links that forces move", .required = false, .range = kFactor},
           p.mass);
  v.Number({.key = "speed",
            .doc = "of prescribed motions, with which all times of the scene pass: horizon, step, samples, grips",
            .required = false,
            .range = kFactor},
           p.speed);
  v.StructList({.key = "starts", .doc = "how starts are moved", .required = false}, p.starts);
}

// ---- Variation ----------------------------------------------------------------------------------------------------

// ---- Learning -----------------------------------------------------------------------------------------------------

static void VisitFields(FieldVisitor& v, Learning& l) {
  static constexpr string_view kMethods[] = {"ours", "simple_continual", "diffhand"};
  v.EnumField({.key = "method", .doc = "schedule", .required = false}, l.method, kMethods);
  static constexpr string_view kParts[] = {"design", "control", "policy"};
  v.LeafList({.key = "optimize", .doc = "what moves; all else stays initial", .required = false}, l.optimize, 1,
             [](FieldVisitor& w, LearnedPart& part) { w.EnumField({}, part, kParts); });
  v.Integer({.key = "variations",
             .doc = "N: training variations; 1 where nothing varies",
             .required = false,
             .range = kRolloutCount},
            l.variations);
  v.Integer({.key = "batch",
             .doc = "M: variations in a batch; 1 where nothing varies",
             .required = false,
             .range = kRolloutCount},
            l.batch);
  v.Integer({.key = "dimensions_per_batch",
             .doc = "d': parameters that move in a batch; left out, no more than there are",
             .required = false,
             .range = kCount},
            l.dimensions_per_batch);
  v.Number({.key = "alpha", .doc = "weight of the distillation loss", .required = false, .range = kNonNegative},
           l.alpha);
  v.Number({.key = "learning_rate",
            .doc = "radius of a batch's box, as a fraction of each parameter's range",
            .required = false,
            .range = kFraction},
           l.learning_rate);
  v.Number({.key = "decay",
            .doc = "factor of the learning rate when all dimensions have been used",
            .required = false,
            .range = kFraction},
           l.decay);
  v.Text(
      {.key = "optimizer",
       .doc = "an NLopt algorithm, or an evolution strategy, plain or drawn along gradients: CMA_ES, CMA_ES_GRADIENT; "
              "these evaluate 16 designs at a time, so give them `max_evaluations` of some 100 and more",
       .required = false,
       .role = TextRole::kName},
      l.optimizer);
  v.Integer(
      {.key = "max_evaluations", .doc = "of the optimizer, in a batch", .required = false, .range = kRolloutCount},
      l.max_evaluations);
  v.Number({.key = "loss_tolerance",
            .doc = "a batch ends when its loss changes by less, relatively; 0: never",
            .required = false,
            .range = kNonNegative},
           l.loss_tolerance);
  v.Number({.key = "parameter_tolerance",
            .doc = "or every parameter by less, as a fraction of its range; 0: never",
            .required = false,
            .range = kNonNegative},
           l.parameter_tolerance);
  v.Integer({.key = "rollout_budget",
             .doc = "at most so many rollouts of learning, shared out over the batches in place of max_evaluations, so "
                    "that methods can be compared at equal numbers; 0: no limit",
             .required = false,
             .range = kSeed},
            l.rollout_budget);
  v.Integer({.key = "validation",
             .doc = "variations, of a stream of their own, on which the designs of all batches are compared; 0: none",
             .required = false,
             .range = {0.0, 1e6}},
            l.validation);
  static constexpr string_view kKeep[] = {"best", "last"};
  v.EnumField({.key = "keep",
               .doc = "what is learned: the best validated design, the initial one included, or that of the last batch",
               .required = false},
              l.keep, kKeep);
  v.Integer({.key = "seed", .doc = "of training", .required = false, .range = kSeed}, l.seed);
  v.LeafList({.key = "start",
              .doc = "where learning starts, in place of the initial values: of all design parameters, then controls, "
                     "then weights, in SI units; `knap learn --from` writes it",
              .required = false},
             l.start, 0, [](FieldVisitor& w, double& x) { w.Number({}, x); });
}

static void VisitFields(FieldVisitor& v, Evaluation& e) {
  v.Integer({.key = "variations",
             .doc = "never seen in training; 1 where nothing varies",
             .required = false,
             .range = kRolloutCount},
            e.variations);
  v.Integer({.key = "seed", .doc = "of the evaluation, a stream of its own", .required = false, .range = kSeed},
            e.seed);
}

static void VisitFields(FieldVisitor& v, GravityDirection& d) {
  v.Number({.key = "azimuth", .doc = "about z, from x", .dimension = kAngle}, d.azimuth);
  v.Number({.key = "rise", .doc = "z component of the direction, -1 down", .range = {-1.0, 1.0}}, d.rise);
}

void VisitBodies(FieldVisitor& v, std::vector<Body>& bodies) {
  v.StructList({.key = "bodies", .doc = "a tree, in any order"}, bodies, 1);
}

void VisitWorld(FieldVisitor& v, World& s) {
  VisitVector(v, "gravity", "in the world", kAcceleration, s.gravity);
  v.OptionalStruct(
      {.key = "gravity_direction", .doc = "turns `gravity`, of which only the size counts then", .required = false},
      s.gravity_direction);
  VisitBodies(v, s.bodies);
  v.StructList({.key = "ropes", .doc = "chains of boxes", .required = false}, s.ropes);
  v.StructList({.key = "contacts", .doc = "pairs of bodies that touch", .required = false}, s.contacts);
  v.StructList({.key = "grips", .doc = "springs that hold for a time", .required = false}, s.grips);
  v.StructList({.key = "signals", .doc = "what is watched: numbers of the state, by name", .required = false},
               s.signals);
}

void VisitTask(FieldVisitor& v, Scene& s) {
  v.Integer({.key = "schema",
             .doc = "version of this format",
             .range = {static_cast<double>(kSceneSchema), static_cast<double>(kSceneSchema)}},
            s.schema);
  v.Text({.key = "name", .doc = "of the scenario", .role = TextRole::kName}, s.name);
  v.Text({.key = "description", .doc = "for people", .required = false}, s.description);
  VisitWorld(v, s);
  const SignalDimensions signals(s);
  v.OptionalStruct({.key = "design", .doc = "what is learned", .required = false}, s.design);
  v.OptionalStruct({.key = "controls", .doc = "open-loop controls of actuators", .required = false}, s.controls);
  v.Struct({.key = "rollout", .doc = "how one variation is simulated"}, s.rollout);
  v.Group({.key = "loss", .doc = "what is minimised", .required = false},
          [&](FieldVisitor& w) { VisitObjective(w, signals, s.loss); });
  v.OptionalStruct(
      {.key = "success", .doc = "what counts as done; without it nothing is called failed", .required = false},
      s.success, [&](FieldVisitor& w, Condition& success) { VisitObjective(w, signals, success); });
  v.OptionalStruct({.key = "policy", .doc = "closed-loop network that drives actuators", .required = false}, s.policy,
                   [&](FieldVisitor& w, Policy& policy) { VisitPolicy(w, signals, policy); });
  v.OptionalStruct({.key = "perturbation",
                    .doc = "how the scene differs from what the rest of the file says; what `knap evaluate --perturb` "
                           "varies",
                    .required = false},
                   s.perturbation);
  v.StructList({.key = "variation", .doc = "what differs between rollouts", .required = false}, s.variation);
  v.Struct({.key = "gradient", .doc = "what gradients are held to", .required = false}, s.gradient);
  v.Struct({.key = "trust", .doc = "what rollouts are held to", .required = false}, s.trust);
}

void VisitFields(FieldVisitor& v, Scene& s) {
  VisitTask(v, s);
  v.Struct({.key = "learning", .doc = "schedule and optimizer", .required = false}, s.learning);
  v.Struct({.key = "evaluation", .doc = "on unseen variations", .required = false}, s.evaluation);
}

}  // namespace knap
