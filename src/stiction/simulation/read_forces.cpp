#include <algorithm>
#include <cmath>

#include "stiction/simulation/plant_impl.hpp"

namespace stiction::simulation {

namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

void read_forces(const Plant::Impl& plant, const mjData* data, std::vector<PairForce>& out) {
  out.clear();
  const std::size_t n = plant.model->geometries().size();
  for (int c = 0; c < data->ncon; ++c) {
    const mjContact& contact = data->contact[c];
    if (contact.efc_address < 0) continue;
    const std::size_t g0 = at(plant.geometry_of[at(contact.geom[0])]), g1 = at(plant.geometry_of[at(contact.geom[1])]);
    const bool forward = plant.pair_of[g1 * n + g0] >= 0;  // the normal points from geom 0 to geom 1: B to A
    const int pair = forward ? plant.pair_of[g1 * n + g0] : plant.pair_of[g0 * n + g1];
    mjtNum local[6];
    mj_contactForce(plant.mujoco.get(), data, c, local);
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> frame(contact.frame);
    const Eigen::Vector3d force = (forward ? 1.0 : -1.0) * (frame.transpose() * Eigen::Map<const Eigen::Vector3d>(local));
    auto entry = std::find_if(out.begin(), out.end(), [&](const PairForce& f) { return f.pair == pair; });
    if (entry == out.end()) entry = out.insert(entry, PairForce{.pair = pair});
    const Eigen::Vector3d normal = (forward ? local[0] : -local[0]) * frame.row(0).transpose();
    // The weight of the newest point in the mean is its share of the force so far; without force the last one counts.
    const double share = entry->normal + local[0] > 0 ? local[0] / (entry->normal + local[0]) : 1.0;
    entry->p_WC += share * (Eigen::Map<const Eigen::Vector3d>(contact.pos) - entry->p_WC);
    entry->normal += local[0];
    entry->force_W += force;
    entry->friction_W += force - normal;
    entry->depth = std::max(entry->depth, -contact.dist);
  }
  for (PairForce& f : out) f.tangential = f.friction_W.norm();
  std::sort(out.begin(), out.end(), [](const PairForce& a, const PairForce& b) { return a.pair < b.pair; });
}

void raise_peaks(const Plant::Impl& plant, const mjData* data, Eigen::VectorXd& peak) {
  for (int j = 0; j < plant.model->n_a(); ++j) {
    const double torque = data->actuator_force[plant.actuator_id[at(j)]];
    if (std::abs(torque) > std::abs(peak[j])) peak[j] = torque;
  }
}

}  // namespace stiction::simulation
