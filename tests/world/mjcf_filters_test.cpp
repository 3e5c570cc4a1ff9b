// Which shapes of an MJCF may touch: excluded bodies, types and affinities, and contact pairs, against the contacts of MuJoCo.
#include <fmt/format.h>

#include <set>

#include "stiction/world/read.hpp"
#include "world/mjcf_oracle.hpp"

namespace stiction::world::test {
namespace {

using Pairs = std::set<std::set<std::string>>;

/// Pairs that may touch. @param full  true: names of bodies and geoms; false: of geoms alone
Pairs pairs_of(const Model& model, bool full = false) {
  Pairs out;
  const auto name = [&](int geometry) {
    const std::string& given = model.geometries()[static_cast<std::size_t>(geometry)].name;
    return full ? given : given.substr(given.find_last_of("/.") + 1);
  };
  for (const Pair& pair : model.pairs()) out.insert({name(pair.geometry_a), name(pair.geometry_b)});
  return out;
}

/// A pusher with a pad, which starts far from a mug with a handle, a case and a case.wall on the floor. They all overlap where the pusher arrives.
std::string cell(const std::string& contact) {
  return fmt::format(R"(<worldbody><geom name="floor" type="plane" size="9 9 1"/>
      <body name="case"><geom name="c" size=".1"/></body><body name="case.wall"><geom name="w" size=".1"/><body name="knob"><geom name="k" size=".1"/></body></body>
      <body name="mug"><freejoint/><geom name="cup" size=".1"/><body name="handle"><geom name="ear" size=".1"/></body></body>
      <body name="pusher" pos="8 0 0"><joint name="x" type="slide" axis="1 0 0" range="-8 8"/><geom name="tip" size=".1"/><body name="pad"><geom name="p" size=".1"/></body></body>
      </worldbody><contact>{}</contact><actuator><position joint="x" kp="9"/></actuator>)",
                     contact);
}

/// Geoms that touch in MuJoCo when the pusher has arrived.
Pairs touching_in_mujoco(const std::filesystem::path& file) {
  const Owned<mjModel> m = load_mujoco(file);
  const Owned<mjData> d(mj_makeData(m.get()));
  d->qpos[m->jnt_qposadr[mj_name2id(m.get(), mjOBJ_JOINT, "x")]] = -8;
  mj_forward(m.get(), d.get());
  Pairs out;
  for (int i = 0; i < d->ncon; ++i)
    out.insert({name_of(m.get(), mjOBJ_GEOM, d->contact[i].geom[0]), name_of(m.get(), mjOBJ_GEOM, d->contact[i].geom[1])});
  return out;
}

TEST(MjcfFilters, ExcludedBodies_AreThoseOfMujoco) {
  for (const auto& [one, other] : {std::pair{"world", "pusher"},
                                   {"pusher", "case"},
                                   {"case.wall", "pad"},
                                   {"handle", "pusher"},
                                   {"mug", "pad"},
                                   {"mug", "case"},
                                   {"world", "handle"},
                                   {"knob", "handle"}}) {
    const auto file = write_mjcf(cell(fmt::format("<exclude body1='{}' body2='{}'/>", one, other)), "cell.xml");
    const Pairs expected = touching_in_mujoco(file);
    EXPECT_EQ(expected.size(), 19u) << "4 fixed and 2 loose geoms under two links, 4 fixed under two loose geoms, without one pair";
    EXPECT_EQ(pairs_of(*Model::make(parse_scene("file: cell.xml", file.parent_path()))), expected) << one << " and " << other;
    Pairs of_robot = expected;  // the case and its wall are links there, and the joint of the pusher links it to them
    std::erase_if(of_robot, [](const std::set<std::string>& pair) {
      return (pair.contains("tip") || pair.contains("p")) && (pair.contains("c") || pair.contains("w") || pair.contains("k"));
    });
    EXPECT_EQ(pairs_of(*Model::make(parse_scene("robots: [{name: r, mjcf: cell.xml}]", file.parent_path()))), of_robot)
        << one << " and " << other;
  }
}

/// A ball on a slide. @param geom  attributes of the ball
std::string slider(const std::string& geom) {
  return fmt::format(
      R"(<worldbody><body name="a"><joint type="slide" axis="1 0 0" range="-.3 .3"/><geom name="ga" size=".05" {}/></body></worldbody>)",
      geom);
}

TEST(MjcfFilters, TypesAndAffinities_CountWithinTheirFile) {
  const auto folder = write_mjcf(slider("contype='1' conaffinity='1'"), "one.xml").parent_path();
  write_mjcf(slider("contype='2' conaffinity='2'"), "two.xml");
  const auto load = [&](const char* robots) {
    return pairs_of(*Model::make(parse_scene(fmt::format("robots: [{}]", robots), folder)), true);
  };
  EXPECT_EQ(load("{name: r, mjcf: one.xml}, {name: s, mjcf: two.xml, base: {position: [0, .2, 0]}}"), (Pairs{{"r/a/ga", "s/a/ga"}}));
  EXPECT_EQ(load("{name: r, mjcf: one.xml}, {name: s, mjcf: one.xml, base: {position: [0, .2, 0]}}"), (Pairs{{"r/a/ga", "s/a/ga"}}));
  EXPECT_EQ(load("{name: r, mjcf: one.xml, mount: {name: m, file: two.xml, on: world, pose: {position: [0, .2, 0]}}}"),
            (Pairs{{"r/a/ga", "r/m_a/ga"}}));
}

TEST(MjcfFilters, GeomsOfContactPairsAlone_TouchTheirPartnersAndOtherFilesShapes) {
  const auto folder =
      write_mjcf(R"(<default><geom size=".05" contype="0" conaffinity="0"/><joint type="slide" axis="1 0 0" range="-.3 .3"/></default>
          <worldbody><body name="a"><joint/><geom name="ga"/></body><body name="b" pos=".3 0 0"><joint/><geom name="gb"/></body>
          <body name="c" pos=".6 0 0"><joint/><geom name="gc"/></body></worldbody><contact><pair geom1="ga" geom2="gb"/></contact>)",
                 "pairs.xml")
          .parent_path();
  EXPECT_EQ(pairs_of(*Model::make(parse_scene(R"(
robots: [{name: r, mjcf: pairs.xml}, {name: s, mjcf: pairs.xml, base: {position: [0, .2, 0]}}]
objects: [{name: box, joint: free, mass: 1, shapes: [{sphere: {radius: .1}}]}])",
                                              folder)),
                     true),
            (Pairs{{"r/a/ga", "r/b/gb"},
                   {"s/a/ga", "s/b/gb"},
                   {"box/sphere_0", "r/a/ga"},
                   {"box/sphere_0", "r/b/gb"},
                   {"box/sphere_0", "s/a/ga"},
                   {"box/sphere_0", "s/b/gb"}}));
}

}  // namespace
}  // namespace stiction::world::test
