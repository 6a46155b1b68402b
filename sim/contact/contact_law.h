// The force law of one contact patch between a sphere and a surface.
//
// The patch is described by the integrals W and g of sphere_triangle.h and by the sphere's motion relative to the
// surface's body: u, the velocity of the sphere's centre, and w, its angular velocity. All vectors in one frame.
//
//   N_e = E/(2r²) |g|,  n = g/|g|,  l = −g/W           elastic force, direction, centre of pressure from the centre
//   N   = N_e ramp(1 − d n·u)                          Hunt–Crossley damping, never adhesive [Hunt & Crossley 1975]
//   s   = (I − n nᵀ) u + w × l                         slip velocity
//   f_t = −mu N s / sqrt(|s|² + v_s²)                  inside the cone of the normal force alone
//   m_r = −c_r r N w_t / sqrt(|w_t|² + (v_s/r)²)       rolling resistance, w_t = (I − n nᵀ) w
//   f   = N n + f_t  on the sphere at its centre,  m = l × f_t + m_r  about its centre
//
// Everything is C¹ in all arguments, also at onset, where N vanishes with zero slope.
#pragma once

#include <Eigen/Dense>

namespace knap {

struct ContactMaterial {
  double stiffness = 0.0;           // E, pressure per depth [N/m³]
  double damping = 0.0;             // d [s/m]
  double friction = 0.0;            // mu [-]
  double rolling_resistance = 0.0;  // c_r, resisting moment over r N [-]
  double slip_speed = 1e-3;         // v_s, where friction reaches 1/√2 of its bound [m/s]
};

struct PatchForce {
  Eigen::Vector3d f = Eigen::Vector3d::Zero();  // [N]
  Eigen::Vector3d m = Eigen::Vector3d::Zero();  // [N m]
  // d(f, m)/d(W, g, u, w): rows f then m, columns 1 + 3 + 3 + 3.
  Eigen::Matrix<double, 6, 10> jacobian = Eigen::Matrix<double, 6, 10>::Zero();
};

// W > 0. `want_jacobian` false leaves the Jacobian zero.
PatchForce CalcPatchForce(const ContactMaterial& material, double r, double W, const Eigen::Vector3d& g,
                          const Eigen::Vector3d& u, const Eigen::Vector3d& w, bool want_jacobian);

}  // namespace knap
