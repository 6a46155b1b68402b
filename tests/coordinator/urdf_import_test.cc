// Robots in URDF, imported, included in a scenario and built, against an independent reader of the same files (KDL):
// masses, inertias and forward kinematics; limits against the numbers in the files. And what knap cannot take is
// refused or told by name.
#include "coordinator/import/urdf_import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <kdl/treefksolverpos_recursive.hpp>
#include <kdl_parser/kdl_parser.hpp>
#include <random>
#include <sstream>

#include "sim/geometry/mesh_io.h"
#include "sim/rollout/build_model.h"
#include "sim/scenarios/parse_scene.h"

namespace knap {
namespace urdf_import_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string Read(const std::string& name) {
  std::ifstream file(std::string(KNAP_SOURCE_DIR) + "/" + name);
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_FALSE(text.str().empty()) << name;
  return text.str();
}

ImportedRobot Import(const std::string& text) { return ImportUrdf(text, {}); }

// A scenario that includes the robot twice, as a user would.
ParseResult Include(const std::string& robot) {
  const std::string scenario =
      "schema: 2\nname: s\nrollout: {horizon: 1 s}\n"
      "include:\n  - {file: r.yaml, name: a}\n"
      "  - {file: r.yaml, name: b, position: [1 m, 2 m, 3 m], orientation_rpy: [0 rad, 0 rad, 1 rad]}\n";
  return ParseScene(scenario, "s.yaml", {}, [&](const std::string& path) { return IncludedText{path, robot}; });
}

Matrix3d ToMatrix(const KDL::Rotation& r) {
  Matrix3d R;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) R(i, j) = r(i, j);
  }
  return R;
}
Vector3d ToVector(const KDL::Vector& v) { return {v(0), v(1), v(2)}; }

class UrdfArm : public testing::TestWithParam<const char*> {};

TEST_P(UrdfArm, EqualsWhatKdlReads) {
  const std::string text = Read(GetParam());
  KDL::Tree kdl;
  ASSERT_TRUE(kdl_parser::treeFromString(text, kdl));
  const ImportedRobot robot = Import(text);
  const ParseResult parsed = Include(FormatImport(robot, "the.urdf", "r.yaml"));
  ASSERT_TRUE(parsed.ok()) << parsed.FormatErrors();
  // Without shapes: meshes are another matter.
  Scene scene = parsed.scene;
  for (Body& body : scene.bodies) body.shapes.clear();
  const SceneModel model = BuildModel(scene, {});
  const std::size_t links = robot.bodies.size();
  ASSERT_EQ(links, kdl.getNrOfSegments() + 1);
  EXPECT_EQ(static_cast<std::size_t>(model.tree.nv()), 2 * kdl.getNrOfJoints());

  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(-3.0, 3.0);
  VectorXd q = model.q0;
  KDL::JntArray q_kdl(kdl.getNrOfJoints());
  for (const auto& [name, element] : kdl.getSegments()) {
    const KDL::Joint& joint = GetTreeElementSegment(element).getJoint();
    if (joint.getType() == KDL::Joint::None) continue;
    q_kdl(GetTreeElementQNr(element)) = angle(random);
    const std::string& body = robot.body_of_joint.at(joint.getName());
    for (const char* which : {"a_", "b_"}) {
      q(model.tree.bodies()[model.joint_index.at(which + body)].q_start) = q_kdl(GetTreeElementQNr(element));
    }
  }
  Dynamics dynamics(model.tree);
  const VectorXd zero = VectorXd::Zero(model.tree.nv());
  dynamics.CalcKinematics(q, zero, zero, 0.0);
  KDL::TreeFkSolverPos_recursive solver(kdl);
  const Pose X_WB{Eigen::AngleAxisd(1.0, Vector3d::UnitZ()).toRotationMatrix(), Vector3d(1.0, 2.0, 3.0)};
  int moving = 0;
  for (const auto& [name, element] : kdl.getSegments()) {
    if (name == kdl.getRootSegment()->first) continue;  // KDL leaves out its inertia
    std::string body = name;
    std::replace(body.begin(), body.end(), ' ', '_');
    KDL::Frame frame;
    ASSERT_GE(solver.JntToCart(q_kdl, frame, name), 0) << name;
    const Pose& X_a = dynamics.kinematics()[model.body_index.at("a_" + body)].X_WB;
    EXPECT_LT((X_a.R - ToMatrix(frame.M)).norm(), 1e-9) << name;
    EXPECT_LT((X_a.p - ToVector(frame.p)).norm(), 1e-9) << name;
    const Pose& X_b = dynamics.kinematics()[model.body_index.at("b_" + body)].X_WB;
    EXPECT_LT((X_b.R - X_WB.R * ToMatrix(frame.M)).norm(), 1e-9) << name;
    EXPECT_LT((X_b.p - X_WB * ToVector(frame.p)).norm(), 1e-9) << name;

    const KDL::Segment& segment = GetTreeElementSegment(element);
    const KDL::RigidBodyInertia& I = segment.getInertia();
    const auto it =
        std::find_if(robot.bodies.begin(), robot.bodies.end(), [&](const Body& b) { return b.name == body; });
    ASSERT_NE(it, robot.bodies.end());
    // Rotational inertia about the link's origin along its axes, in KDL's order.
    Matrix3d of_kdl;
    for (int i = 0; i < 9; ++i) of_kdl(i / 3, i % 3) = I.getRotationalInertia().data[i];
    const Vector3d moment = I.getMass() * ToVector(I.getCOG());
    const Matrix6d& M = model.tree.bodies()[model.joint_index.at("a_" + body)].M;
    if (!it->inertia) {
      EXPECT_EQ(I.getMass(), 0.0) << name;
      continue;
    }
    EXPECT_NEAR(M(5, 5), I.getMass(), 1e-9) << name;
    EXPECT_LT((M.topLeftCorner<3, 3>() - of_kdl).norm(), 1e-9) << name;
    EXPECT_LT((Vector3d(M(2, 4), M(0, 5), M(1, 3)) - moment).norm(), 1e-9) << name;
    ++moving;
  }
  EXPECT_GE(moving, 4);
}

INSTANTIATE_TEST_SUITE_P(Arms, UrdfArm,
                         testing::Values("configs/gallery/robots/seven_joints.urdf",  //
                                         "tests/data/urdf/six_joints.urdf", "tests/data/urdf/scara.urdf"),
                         [](const auto& the_case) {
                           const std::string name = the_case.param;
                           const std::size_t begin = name.find_last_of('/') + 1;
                           return name.substr(begin, name.find('.') - begin);
                         });

const Body& FindBody(const ImportedRobot& robot, const std::string& name) {
  for (const Body& body : robot.bodies) {
    if (body.name == name) return body;
  }
  throw std::logic_error(name);
}

TEST(UrdfImport, TakesLimitsEffortsAndDamping) {
  const ImportedRobot seven = Import(Read("configs/gallery/robots/seven_joints.urdf"));
  const auto& first = std::get<RevoluteJoint>(FindBody(seven, "link1").joint.kind);
  EXPECT_EQ(first.limits->lower, -2.9);
  EXPECT_EQ(first.limits->upper, 2.9);
  EXPECT_EQ(first.damping, 0.5);
  EXPECT_EQ(std::get<ForceActuator>(*first.actuator).limit, 87.0);
  EXPECT_EQ(first.limits->stiffness * kStopTravel, 87.0);
  // A joint starts where its range lets it.
  EXPECT_EQ(std::get<RevoluteJoint>(FindBody(seven, "link4").joint.kind).initial.angle, -0.07);
  const auto& last = std::get<RevoluteJoint>(FindBody(seven, "link7").joint.kind);
  EXPECT_FALSE(last.limits);
  EXPECT_EQ(last.axis.z(), -1.0);
  const ImportedRobot six = Import(Read("tests/data/urdf/six_joints.urdf"));
  const auto& finger = std::get<PrismaticJoint>(FindBody(six, "left_finger").joint.kind);
  EXPECT_EQ(finger.limits->lower, 0.002);
  EXPECT_EQ(finger.limits->upper, 0.04);
  EXPECT_EQ(finger.initial.displacement, 0.002);
  EXPECT_THAT(six.remarks, ElementsAre("joint left: dry friction of 0.2 left out"));
}

TEST(UrdfImport, TakesCollisionShapesAndTellsWhatItLeavesOut) {
  TriangleMesh mesh;
  mesh.vertices = {Vector3d(0, 0, 0), Vector3d(0.1, 0, 0), Vector3d(0, 0.1, 0), Vector3d(0, 0, 0.1)};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  std::string asked;
  UrdfOptions options;
  options.read_mesh = [&](const std::string& uri) -> std::optional<std::string> {
    asked += uri + "\n";
    if (uri.ends_with("missing.stl")) return std::nullopt;
    return WriteStl(mesh);
  };
  const ImportedRobot scara = ImportUrdf(Read("tests/data/urdf/scara.urdf"), options);
  EXPECT_EQ(asked, "package://scara_description/meshes/arm.stl\npackage://scara_description/meshes/missing.stl\n");
  ASSERT_EQ(scara.meshes.size(), 1u);
  EXPECT_EQ(scara.meshes.begin()->first, "meshes/arm.stl");
  const auto& arm = std::get<MeshShape>(FindBody(scara, "inner_arm").shapes.at(0).kind);
  EXPECT_EQ(arm.file, "meshes/arm.stl");
  EXPECT_EQ(arm.unit, 0.001);
  EXPECT_THAT(scara.remarks,
              ElementsAre("link outer_arm: mesh package://scara_description/meshes/missing.stl left out: the file "
                          "cannot be found"));
  EXPECT_THAT(FindBody(scara, "outer_arm").shapes, IsEmpty());
  const auto& quill = std::get<CylinderShape>(FindBody(scara, "quill").shapes.at(0).kind);
  EXPECT_EQ(quill.radius, 0.01);
  EXPECT_EQ(quill.length, 0.2);
  EXPECT_EQ(FindBody(scara, "quill").shapes[0].position.z(), -0.1);

  mesh.triangles.pop_back();
  const ImportedRobot open = ImportUrdf(Read("tests/data/urdf/scara.urdf"), options);
  EXPECT_THAT(open.remarks.at(0), HasSubstr("it is not closed"));
}

TEST(UrdfImport, JointsFollowAPathWhereOneIsGiven) {
  UrdfOptions options;
  options.path_file = "moves.csv";
  const ImportedRobot robot = ImportUrdf(Read("tests/data/urdf/scara.urdf"), options);
  const auto& slide = std::get<JointPathMotion>(std::get<PrescribedJoint>(FindBody(robot, "quill").joint.kind).motion);
  EXPECT_EQ(slide.file, "moves.csv");
  EXPECT_EQ(slide.column, "depth");
  EXPECT_EQ(slide.kind, JointPathKind::kShift);
  EXPECT_EQ(slide.axis.z(), -1.0);
  EXPECT_TRUE(Include(FormatImport(robot, "x", "r.yaml")).ok());
}

std::string Complain(const std::string& text) {
  try {
    Import(text);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "nothing";
}

TEST(UrdfImport, RefusesByNameWhatItCannotTake) {
  const std::string link =
      "<link name='a'/><link name='b'><inertial><mass value='1'/>"
      "<inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link>";
  const auto joint = [](const std::string& type, const std::string& more) {
    return "<joint name='j' type='" + type + "'><parent link='a'/><child link='b'/>" + more + "</joint>";
  };
  const std::string limit = "<limit lower='0' upper='1' effort='1' velocity='1'/>";
  const auto robot = [](const std::string& parts) { return "<robot name='r'>" + parts + "</robot>"; };
  EXPECT_EQ(Complain(robot(link + joint("revolute", limit))), "nothing");
  EXPECT_EQ(Complain(robot(link + joint("revolute", limit + "<mimic joint='k'/>"))),
            "joint 'j': mimics 'k', which knap cannot; import with --follow, or without the mimic");
  EXPECT_EQ(Complain(robot("<link name='a'/><link name='b'/>" + joint("revolute", limit))),
            "link 'b': moves by joint 'j' and has no mass");
  EXPECT_EQ(
      Complain(robot("<link name='a b'/><link name='a-b'/><joint name='j' type='fixed'><parent link='a b'/><child "
                     "link='a-b'/></joint>")),
      "link 'a-b': its name would be 'a_b', which is taken; give it another one");
  EXPECT_EQ(Complain(robot(link + joint("planar", "<axis xyz='1 0 0'/>"))),
            "joint 'j': planar with another normal than z of its own frame");
  EXPECT_NE(Complain("<robot name='r'>"), "nothing");
  EXPECT_NE(Complain(robot("")), "nothing");
  EXPECT_NE(Complain(robot(link)), "nothing");  // two roots
  EXPECT_NE(Complain(""), "nothing");
}

}  // namespace urdf_import_test
}  // namespace knap
