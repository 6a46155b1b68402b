#include "coordinator/report/trajectory_file.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

// The same rotation has two quaternions: the one nearer to the previous, so that columns are smooth.
std::vector<Eigen::Quaterniond> ListOrientations(const Recording::Body& body) {
  std::vector<Eigen::Quaterniond> out;
  for (const Pose& X_WB : body.X_WB) {
    Eigen::Quaterniond q(X_WB.R);
    if (out.empty() ? q.w() < 0.0 : q.dot(out.back()) < 0.0) q.coeffs() *= -1.0;
    out.push_back(q);
  }
  return out;
}

struct Column {
  std::string name;
  std::function<double(std::size_t row)> value;
};

std::vector<Column> ListColumns(const Recording& recording) {
  std::vector<Column> columns{{"time", [&](std::size_t k) { return recording.time[k]; }}};
  const char* axes[] = {"x", "y", "z"};
  for (const Recording::Body& body : recording.bodies) {
    for (int i = 0; i < 3; ++i) {
      columns.push_back({body.name + "." + axes[i], [&body, i](std::size_t k) { return body.X_WB[k].p(i); }});
    }
    const std::vector<Eigen::Quaterniond> q = ListOrientations(body);
    columns.push_back({body.name + ".qw", [q](std::size_t k) { return q[k].w(); }});
    for (int i = 0; i < 3; ++i) {
      columns.push_back({body.name + ".q" + axes[i], [q, i](std::size_t k) { return q[k].vec()(i); }});
    }
  }
  for (const Recording::Joint& joint : recording.joints) {
    columns.push_back({joint.body + ".joint", [&joint](std::size_t k) { return joint.q[k]; }});
  }
  for (const Recording::Signal& signal : recording.signals) {
    columns.push_back({"signal." + signal.name, [&signal](std::size_t k) { return signal.values[k]; }});
  }
  for (const Recording::Contact& contact : recording.contacts) {
    const std::string pair = contact.bodies[0] + "|" + contact.bodies[1];
    for (int i = 0; i < 3; ++i) {
      columns.push_back({pair + ".f" + axes[i], [&contact, i](std::size_t k) { return contact.f_W[k](i); }});
    }
    for (int i = 0; i < 3; ++i) {
      columns.push_back({pair + ".p" + axes[i], [&contact, i](std::size_t k) { return contact.p_W[k](i); }});
    }
    columns.push_back({pair + ".depth", [&contact](std::size_t k) { return contact.depth[k]; }});
  }
  return columns;
}

Json MakeRow(const Eigen::Vector3d& v) {
  if (!v.allFinite()) return nullptr;
  return {v.x(), v.y(), v.z()};
}

}  // namespace

std::string FormatTrajectoryCsv(const Recording& recording) {
  const std::vector<Column> columns = ListColumns(recording);
  std::string text;
  for (const Column& column : columns) text += (text.empty() ? "" : ",") + column.name;
  text += '\n';
  for (std::size_t k = 0; k < recording.time.size(); ++k) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const double value = columns[i].value(k);
      if (i > 0) text += ',';
      if (std::isfinite(value)) text += fmt::format("{}", value);
    }
    text += '\n';
  }
  return text;
}

Json MakeTrajectoryJson(const Recording& recording) {
  Json bodies = Json::object();
  for (const Recording::Body& body : recording.bodies) {
    Json position = Json::array();
    Json orientation = Json::array();
    const std::vector<Eigen::Quaterniond> q = ListOrientations(body);
    for (std::size_t k = 0; k < q.size(); ++k) {
      position.push_back(MakeRow(body.X_WB[k].p));
      orientation.push_back({q[k].w(), q[k].x(), q[k].y(), q[k].z()});
    }
    bodies[body.name] = {{"position", std::move(position)}, {"orientation_wxyz", std::move(orientation)}};
  }
  Json joints = Json::object();
  for (const Recording::Joint& joint : recording.joints) joints[joint.body] = {{"unit", joint.unit}, {"q", joint.q}};
  Json signals = Json::object();
  for (const Recording::Signal& signal : recording.signals) {
    signals[signal.name] = {{"unit", signal.unit}, {"values", signal.values}};
  }
  Json contacts = Json::array();
  for (const Recording::Contact& contact : recording.contacts) {
    Json force = Json::array();
    Json place = Json::array();
    for (std::size_t k = 0; k < contact.f_W.size(); ++k) {
      force.push_back(MakeRow(contact.f_W[k]));
      place.push_back(MakeRow(contact.p_W[k]));
    }
    contacts.push_back({{"between", contact.bodies},
                        {"force", std::move(force)},
                        {"place", std::move(place)},
                        {"depth", contact.depth}});
  }
  return {{"time", recording.time},
          {"bodies", std::move(bodies)},
          {"joints", std::move(joints)},
          {"signals", std::move(signals)},
          {"contacts", std::move(contacts)}};
}

}  // namespace knap
