#include "stiction/sensing/scenario.hpp"

namespace stiction::sensing {

std::vector<ContactPoint> Scenario::contacts_at(std::size_t moment) const {
  if (series.pushed.empty()) return contacts;
  std::vector<ContactPoint> out;
  for (const int push : series.pushed[moment])
    out.push_back(contacts[static_cast<std::size_t>(poke->pushes[static_cast<std::size_t>(push)].contact)]);
  return out;
}

const BaseWrench* Scenario::base_at(std::size_t moment) const {
  if (!series.base.empty()) return &series.base[moment];
  return base ? &*base : nullptr;
}

ContactSetOptions Scenario::set_options() const {
  ContactSetOptions out;
  out.sense = options;
  out.max_contacts = max_contacts;
  return out;
}

}  // namespace stiction::sensing
