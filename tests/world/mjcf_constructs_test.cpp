#include <regex>
#include <tuple>

#include "support/temporary_folder.hpp"
#include "world/mjcf_oracle.hpp"

// What of MJCF is read and what is refused: files written here, one construct each, and all models that MuJoCo's wheel brings. Both are
// judged by MuJoCo: kinematics by its own, what is not supported by the elements that its parser finds in the file.

namespace stiction::world::test {
namespace {

namespace fs = std::filesystem;

// ---- what MuJoCo's parser finds

bool has_spring(const double* stiffness) {
  return std::any_of(stiffness, stiffness + mjNPOLY + 1, [](double k) { return k != 0; });
}

bool is_limited(mjtLimited limited, const double* range) {
  return limited == mjLIMITED_TRUE || (limited == mjLIMITED_AUTO && range[0] < range[1]);
}

bool collides(const mjsGeom* geom) { return (geom->contype | geom->conaffinity) != 0; }

template <class F>
void for_each(const mjSpec* spec, mjtObj type, F&& f) {
  for (mjsElement* e = mjs_firstElement(spec, type); e != nullptr; e = mjs_nextElement(spec, e)) f(e);
}

/// The body and those above it without the world.
std::vector<mjsBody*> chain_of(mjsBody* body) {
  std::vector<mjsBody*> out;
  for (; body != nullptr && mjs_getId(body->element) > 0; body = mjs_getParent(body->element)) out.push_back(body);
  return out;
}

int count(mjsBody* body, mjtObj type) {
  int n = 0;
  for (mjsElement* e = mjs_firstChild(body, type, false); e != nullptr; e = mjs_nextChild(body, e, false)) ++n;
  return n;
}

bool is_free(mjsBody* body) {
  mjsElement* joint = mjs_firstChild(body, mjOBJ_JOINT, false);
  return joint != nullptr && mjs_asJoint(joint)->type == mjJNT_FREE;
}

bool has_higher_spring(const double* stiffness) {
  return std::any_of(stiffness + 1, stiffness + mjNPOLY + 1, [](double k) { return k != 0; });
}

/// A tendon over joints alone.
bool is_fixed(mjsElement* tendon) {
  const mjsTendon* t = mjs_asTendon(tendon);
  for (int i = 0; i < mjs_getWrapNum(t); ++i) {
    if (mjs_getWrap(t, i)->type != mjWRAP_JOINT) return false;
  }
  return true;
}

using Elements = std::multiset<std::string>;

struct Unsupported {
  Elements refused, passed;
};

/// Elements of a compiled specification that the project refuses or passes over, as its messages name them.
Unsupported unsupported_elements(const mjSpec* spec) {
  Unsupported out;
  const auto insert = [](Elements& into, const std::string& kind, mjsElement* e) {
    const std::string name = mjs_getString(mjs_getName(e));
    into.insert(name.empty() ? kind + " " + std::to_string(mjs_getId(e)) : kind + " '" + name + "'");
  };
  const auto add = [&](const std::string& kind, mjsElement* e) { insert(out.refused, kind, e); };
  const auto pass = [&](const std::string& kind, mjsElement* e) { insert(out.passed, kind, e); };
  std::set<mjsBody*> collides_somewhere;  // bodies at or below which a geom collides
  for_each(spec, mjOBJ_GEOM, [&](mjsElement* e) {
    if (!collides(mjs_asGeom(e))) return;
    for (mjsBody* body : chain_of(mjs_getParent(e))) collides_somewhere.insert(body);
  });
  for_each(spec, mjOBJ_JOINT, [&](mjsElement* e) {
    const mjsJoint* joint = mjs_asJoint(e);
    const bool on_axis = joint->type == mjJNT_HINGE || joint->type == mjJNT_SLIDE;
    if (has_spring(joint->stiffness) && (!on_axis || has_higher_spring(joint->stiffness))) pass("joint", e);
  });
  for_each(spec, mjOBJ_BODY, [&](mjsElement* e) {
    mjsBody* body = mjs_asBody(e);
    const auto chain = chain_of(body);
    if (chain.empty()) return;
    if (count(body, mjOBJ_JOINT) > 0 && std::any_of(chain.begin() + 1, chain.end(), is_free)) add("body", e);
    if (is_free(body) && !collides_somewhere.contains(body)) pass("body", e);
    bool carries = false;
    for_each(spec, mjOBJ_JOINT, [&](mjsElement* joint) {
      const auto above = chain_of(mjs_getParent(joint));
      carries = carries || std::find(above.begin(), above.end(), body) != above.end();
    });
    if (body->mocap && carries) add("body", e);
    if (body->mocap && collides_somewhere.contains(body)) pass("body", e);
  });
  for_each(spec, mjOBJ_GEOM, [&](mjsElement* e) {
    const mjsGeom* geom = mjs_asGeom(e);
    if (std::any_of(geom->surfacevel, geom->surfacevel + 6, [](double v) { return v != 0; })) pass("geom", e);
    if (!collides(geom)) return;
    if (geom->adhesion != 0) pass("geom", e);
    if (geom->type == mjGEOM_HFIELD || geom->type == mjGEOM_SDF) add("geom", e);
  });
  for_each(spec, mjOBJ_EQUALITY, [&](mjsElement* e) {
    const mjsEquality* equality = mjs_asEquality(e);
    if (equality->active && equality->type != mjEQ_JOINT) pass("equality", e);
  });
  for_each(spec, mjOBJ_TENDON, [&](mjsElement* e) {
    const mjsTendon* tendon = mjs_asTendon(e);
    if (has_spring(tendon->stiffness)) pass("tendon", e);
    const bool one_joint = is_fixed(e) && mjs_getWrapNum(tendon) == 1;  // whose limits these are
    if (is_limited(tendon->limited, tendon->range) && !one_joint) pass("tendon", e);
  });
  for_each(spec, mjOBJ_ACTUATOR, [&](mjsElement* e) {
    const mjsActuator* actuator = mjs_asActuator(e);
    const bool on_joint = actuator->trntype == mjTRN_JOINT || actuator->trntype == mjTRN_JOINTINPARENT;
    mjsElement* joint = on_joint ? mjs_findElement(const_cast<mjSpec*>(spec), mjOBJ_JOINT, mjs_getString(actuator->target)) : nullptr;
    const bool fixed_tendon = actuator->trntype == mjTRN_TENDON &&
                              is_fixed(mjs_findElement(const_cast<mjSpec*>(spec), mjOBJ_TENDON, mjs_getString(actuator->target)));
    if ((!on_joint && !fixed_tendon) || (joint != nullptr && mjs_asJoint(joint)->type == mjJNT_FREE)) pass("actuator", e);
  });
  for_each(spec, mjOBJ_FLEX, [&](mjsElement* e) { add("flex", e); });
  for_each(spec, mjOBJ_PLUGIN, [&](mjsElement* e) { pass("plugin", e); });
  return out;
}

/// What MuJoCo's parser makes of a file, compiled so that elements have their numbers.
Owned<mjSpec> parse(const fs::path& file) {
  char error[1000] = "";
  mjSpec* spec = nullptr;
  mjModel* compiled = nullptr;
  call_mujoco([&] {
    spec = mj_parseXML(file.c_str(), nullptr, error, sizeof(error));
    if (spec != nullptr) compiled = mj_compile(spec, nullptr);
  });
  if (compiled == nullptr) ADD_FAILURE() << file << ": " << (spec == nullptr ? error : mjs_getError(spec));
  mj_deleteModel(compiled);
  return Owned<mjSpec>(spec);
}

/// Elements of a list "joint 'a' (a reason); geom 3 (another)", without their reasons.
Elements named_in(const std::string& list) {
  static const std::regex element("(\\w+ (?:'[^']*'|\\d+)) \\([^)]+\\)(?:; |$)");
  Elements out;
  for (std::sregex_iterator i(list.begin(), list.end(), element), end; i != end; ++i) out.insert((*i)[1]);
  return out;
}

Elements refused_in(const std::string& message) {
  static const std::regex head("mjcf: got (\\d+) unsupported elements?: (.*), expected hinge, ");
  std::smatch found;
  if (!std::regex_search(message, found, head)) return {"nothing: " + message};
  const Elements out = named_in(found[2]);
  EXPECT_EQ(out.size(), std::stoul(found[1])) << message;
  return out;
}

Elements passed_in(const std::vector<std::string>& notes) {
  static const std::string head = "passed over: ";
  for (const std::string& note : notes) {
    if (!note.starts_with(head)) continue;
    Elements passed = named_in(note.substr(head.size()));
    std::erase_if(passed, [](const std::string& element) {
      return element.starts_with("pair");
    });  // which depend on joints and filters: mjcf_test.cpp
    return passed;
  }
  return {};
}

/// Loads, stands where MuJoCo has it and names what it passes over, or names exactly the elements that stand against it. Returns whether it
/// loaded.
bool loads_or_names_why_not(const fs::path& file) {
  const std::string message = message_of_file(file);
  const Unsupported unsupported = unsupported_elements(parse(file).get());
  if (message.empty()) {
    EXPECT_EQ(unsupported.refused, Elements{}) << file;
    EXPECT_EQ(passed_in(read_mjcf(file).robot.notes), unsupported.passed) << file;
    compare_kinematics(file);
  } else {
    EXPECT_EQ(refused_in(message), unsupported.refused) << file;
    EXPECT_FALSE(unsupported.refused.empty()) << message;
  }
  return message.empty();
}

// ---- constructs

struct Construct {
  const char* name;
  const char* content;  ///< of <mujoco>
  void operator()(const fs::path& file) const { std::ofstream(file) << "<mujoco>" << content << "</mujoco>"; }
  friend std::ostream& operator<<(std::ostream& out, const Construct& c) { return out << c.name; }
};

std::string name_of_construct(const testing::TestParamInfo<Construct>& info) { return info.param.name; }

class MjcfReads : public testing::TestWithParam<Construct> {};
class MjcfRefuses : public testing::TestWithParam<Construct> {};

TEST_P(MjcfReads, File_StandsWhereMujocoHasIt) {
  EXPECT_TRUE(loads_or_names_why_not(write_mjcf(GetParam().content, std::string(GetParam().name) + ".xml")))
      << message_of_file(stiction::test::folder_of_the_process() / (std::string(GetParam().name) + ".xml"));
}

TEST_P(MjcfRefuses, File_IsRefusedByItsElements) {
  EXPECT_FALSE(loads_or_names_why_not(write_mjcf(GetParam().content, std::string(GetParam().name) + ".xml")));
}

// clang-format off
const Construct kRead[] = {
    {"Orientations", R"(<compiler angle="radian" eulerseq="ZYx"/>
       <worldbody><body euler="0.3 -0.2 0.5" pos="1 2 3"><joint axis="1 2 3"/><geom size=".1" pos=".1 0 0"/>
         <body axisangle="1 1 0 0.7" pos="0 0 1"><joint axis="0 1 0"/><geom type="box" size=".1 .2 .3" xyaxes="1 1 0 -1 1 0"/>
           <body zaxis="1 0 1" pos="0 .5 0"><joint/><geom type="capsule" size=".1 .2" quat="2 0 1 0"/>
             <body xyaxes="0 1 0 -1 0 0.2"><joint type="slide"/><geom type="cylinder" size=".1 .2" axisangle="0 1 0 1"/></body>
       </body></body></body></worldbody>)"},
    {"Fromto", R"(<worldbody><body pos="0 0 1"><joint/><geom type="capsule" size=".05" fromto="0 0 0 .3 .1 0"/>
       <geom type="box" size=".05" fromto="0 0 0 0 .3 .2"/><geom type="cylinder" size=".05" fromto=".1 0 0 0 0 .4"/></body></worldbody>)"},
    {"Frames", R"(<worldbody><frame pos="1 0 0" euler="0 30 0"><frame euler="10 0 0"><body pos="0 1 0"><joint axis="1 0 0"/>
       <frame pos="0 0 .2" quat="1 1 0 0"><geom size=".1"/><body pos=".3 0 0"><joint axis="0 1 0" pos="0 .1 0"/><geom type="box" size=".1 .1 .1"/></body></frame>
       </body></frame><geom type="box" size=".2 .1 .1"/></frame></worldbody>)"},
    {"Replicate", R"(<worldbody><replicate count="4" offset=".3 0 0.1" euler="0 0 40"><body name="leg" pos="1 0 0"><joint name="hip" axis="0 1 0"/>
       <geom name="shin" type="capsule" size=".02 .1"/></body></replicate></worldbody>)"},
    {"NestedDefaults", R"(<default><joint axis="0 1 0" pos="0 0 .1"/><geom type="capsule" size=".03 .1"/><default class="a"><joint type="slide" range="-.1 .2"/>
       <default class="b"><geom type="box" size=".1 .1 .2" euler="0 0 45"/></default></default></default>
       <worldbody><body childclass="a" pos="0 0 1"><joint/><geom/><body childclass="b" pos=".2 0 0"><joint ref=".1"/><geom/><geom class="main" pos="0 0 .3"/></body></body></worldbody>)"},
    {"FreeBodies", R"(<worldbody><body name="a" pos="0 0 1" euler="20 0 0"><freejoint/><geom type="box" size=".1 .2 .3" pos=".05 0 0"/></body>
       <body pos="1 0 1" euler="0 20 0"><freejoint align="true"/><geom type="capsule" size=".1 .2" fromto="0 0 0 .1 .2 .3"/><body pos=".3 0 0" euler="0 0 30"><geom size=".05"/>
         <body pos="0 .2 0"><geom class="main" type="cylinder" size=".1 .02"/></body></body></body></worldbody>)"},
    {"SeveralJoints", R"(<worldbody><body pos="0 0 .5" euler="0 10 0"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0" ref=".3"/>
       <joint axis="0 0 1" pos=".1 .2 0" ref="40"/><geom size=".1"/><body pos=".4 0 0"><joint axis="1 0 0" pos="0 0 .1"/><joint axis="0 1 0"/><geom size=".1"/></body></body></worldbody>)"},
    {"Meshes", R"(<asset><mesh name="a" vertex="0 0 0 1 0 0 0 1 0 0 0 1" scale=".1 .2 -.3"/><mesh name="b" builtin="sphere" params="1" scale=".1 .1 .2" refpos=".1 0 0"/>
       <mesh name="c" vertex="-1 -1 -1 1 -1 -1 1 1 -1 -1 1 -1 -1 -1 1 1 -1 1 1 1 1 -1 1 1" scale=".1 .2 .3" refquat="1 1 0 0"/></asset>
       <worldbody><geom type="mesh" mesh="a" pos="1 0 0" euler="0 0 30"/><body><joint/><geom type="mesh" mesh="a" euler="20 0 0"/><geom type="mesh" mesh="b" pos="0 0 1"/>
       <geom type="box" mesh="c" pos="0 1 0"/><geom type="capsule" mesh="c"/></body><body><freejoint/><geom type="mesh" mesh="b"/></body></worldbody>)"},
    {"Actuators", R"(<worldbody><body><joint name="a"/><geom size=".1"/><body><joint name="b" type="slide"/><geom size=".1"/><body><joint name="c"/><geom size=".1"/></body></body></body></worldbody>
       <actuator><position joint="a" kp="10" kv="1"/><position joint="b" kp="10" dampratio="1" timeconst=".1"/><general joint="c" gainprm="5" biastype="affine" biasprm="0 -5 -1"/>
       <motor joint="a" gear="3"/><velocity joint="b" kv="2"/><intvelocity joint="c" kp="3" actrange="-1 1"/><damper joint="a" kv="1" ctrlrange="0 1"/><cylinder joint="b" diameter=".1"/>
       <muscle joint="c" lengthrange="0 1"/><position jointinparent="a" kp="1"/></actuator>)"},
    {"OnlySeen", R"(<asset><hfield name="h" nrow="2" ncol="2" size="1 1 1 1"/><texture name="t" builtin="flat" type="2d" width="8" height="8"/><material name="m" texture="t"/></asset>
       <worldbody><light pos="0 0 3"/><camera pos="0 0 2"/><site name="s" size=".1"/><geom type="hfield" hfield="h" contype="0" conaffinity="0"/>
       <body><joint/><geom type="ellipsoid" size=".1 .2 .3" contype="0" conaffinity="0" material="m"/><geom size=".1"/><site type="ellipsoid" size=".1 .2 .3"/><camera/><light/></body>
       <body name="target" mocap="true" pos="1 1 1"><geom type="box" size=".1 .1 .1" contype="0" conaffinity="0"/><body pos="0 0 1"><site/></body></body></worldbody>)"},
    {"WhatHoldsNothing", R"(<worldbody><body name="b"><joint name="j" damping="3" frictionloss="1" armature=".1"/><geom size=".1"/><site name="p"/></body><site name="q" pos="0 0 1"/></worldbody>
       <tendon><spatial name="ruler"><site site="p"/><site site="q"/></spatial><fixed name="sum" damping="1"><joint joint="j" coef="2"/></fixed></tendon>
       <equality><joint joint1="j" active="false"/><weld body1="b" active="false"/></equality>)"},
    {"EverythingBesides", R"(<option timestep=".01" integrator="implicitfast" gravity="0 0 -1" wind="1 0 0" density="1"><flag energy="enable"/></option><size memory="1M"/>
       <statistic extent="2"/><visual><map znear=".1"/></visual><compiler autolimits="true" balanceinertia="true" boundmass=".01" boundinertia=".001" settotalmass="3"/>
       <worldbody><body name="b" gravcomp="1" user="1"><inertial pos="0 .1 0" mass="2" fullinertia="1 1 1 .1 0 0"/><joint name="j" range="-30 40" margin=".1" springref="20" actuatorfrcrange="-1 1"/>
       <geom size=".1" condim="6" friction=".5 .1 .01" solref=".01 1" priority="2" margin=".1" gap=".05" group="3" rgba="1 0 0 1"/></body></worldbody>
       <sensor><jointpos joint="j"/><framepos objtype="body" objname="b"/></sensor><keyframe><key qpos=".2"/></keyframe><custom><numeric name="n" data="1 2"/></custom>)"},
    {"StandingStill", R"(<worldbody><body name="table" pos="1 0 0" euler="0 0 20"><geom type="plane" size="1 1 1" pos="0 0 .4"/><geom type="box" size=".1 .1 .4"/><body pos="0 0 .5"><geom size=".1"/>
       <body name="arm"><joint/><geom size=".05" pos=".2 0 0"/></body></body></body><geom type="plane" size="0 0 1" euler="0 5 0"/></worldbody>
       <contact><exclude body1="world" body2="arm"/><exclude body1="table" body2="arm"/></contact>)"},
    {"OddNames", R"(<worldbody><body name="left/arm 1"><joint name="hip/roll *"/><geom name="a/b" size=".1"/><body name="left/arm 2"><joint name="knee"/><geom name="a b" size=".1"/></body></body></worldbody>)"},
    {"SpringOfADefault", R"(<default><default class="soft"><joint stiffness="1"/></default></default><worldbody><body><joint name="a"/><joint name="s" class="soft" axis="1 0 0"/><geom size=".1"/></body></worldbody>)"},
    {"Adhesion", R"(<worldbody><body><joint/><geom name="glue" size=".1" adhesion="1"/></body></worldbody>)"},
    {"Equalities", R"(<worldbody><body name="b"><joint name="j"/><geom size=".1"/></body></worldbody><equality><joint name="lock" joint1="j"/><connect body1="b" anchor="0 0 1"/></equality>)"},
    {"Tendons", R"(<worldbody><body><joint name="j"/><geom size=".1"/></body></worldbody><tendon><fixed name="spring" stiffness="1"><joint joint="j" coef="1"/></fixed>
       <fixed name="stop" range="-1 1"><joint joint="j" coef="1"/></fixed><fixed name="both" range="-1 1" limited="true" stiffness="2"><joint joint="j" coef="1"/></fixed></tendon>)"},
    {"ActuatorsBesideJoints", R"(<worldbody><body name="b"><joint name="j"/><geom size=".1"/><site name="s"/></body><body><joint name="f" type="free"/><geom size=".1"/></body></worldbody>
       <tendon><fixed name="t"><joint joint="j" coef="1"/></fixed></tendon>
       <actuator><motor name="on_tendon" tendon="t"/><motor site="s"/><adhesion name="suck" body="b" ctrlrange="0 1"/><motor name="jet" joint="f"/></actuator>)"},
    {"CoupledJoints", R"(<worldbody><body><joint name="a" ref="20"/><geom size=".1"/><body pos=".3 0 0"><joint name="b" axis="0 1 0" ref="-10"/><geom size=".1"/>
       <body pos=".3 0 0"><joint name="c" type="slide" ref=".1"/><geom size=".1"/></body></body></body><body pos="0 1 0"><joint name="d" axis="1 0 0" ref="5"/><geom size=".1" pos="0 .1 0"/></body></worldbody>
       <equality><joint joint1="b" joint2="a" polycoef=".2 -.7 0 0 0"/><joint joint1="c" joint2="b" polycoef="0 .1 0 0 0"/><joint joint1="d" polycoef=".3 0 0 0 0"/></equality>)"},
    {"FreeBodyThatIsOnlySeen", R"(<worldbody><body name="arm"><joint/><geom size=".1"/></body><body name="target" pos="1 0 0"><freejoint/><geom size=".1" contype="0" conaffinity="0"/></body></worldbody>
       <contact><exclude body1="arm" body2="target"/></contact>)"},
    {"BallsAndEllipsoids", R"(<worldbody><body pos="0 0 1" euler="0 20 0"><joint name="ball" type="ball" pos=".1 0 0"/><geom type="ellipsoid" size=".1 .2 .3" euler="10 0 0"/>
       <body pos=".3 0 0"><joint name="knee"/><joint name="ankle" type="ball" stiffness="2"/><geom size=".1"/></body></body></worldbody>)"},
    {"MocapThatCollides", R"(<worldbody><body name="wand" mocap="true"><body><geom size=".1"/></body></body><body pos="1 0 0"><joint name="knee"/><geom size=".1"/></body></worldbody>)"},
    {"Nothing", ""},
};

const Construct kRefused[] = {
    {"Geoms", R"(<asset><hfield name="h" nrow="2" ncol="2" size="1 1 1 1"/></asset><worldbody><geom name="hills" type="hfield" hfield="h"/>
       <geom name="belt" type="box" size="1 1 1" surfacevel="1 0 0 0 0 0"/></worldbody>)"},
    {"FreeBodyWithLegs", R"(<worldbody><body name="walker"><freejoint/><geom size=".1"/><body><geom size=".1"/><body name="leg"><joint/><geom size=".1"/></body></body></body></worldbody>)"},
    {"Mocap", R"(<worldbody><body name="handle" mocap="true"><body><joint/><geom size=".1"/></body></body></worldbody>)"},
    {"PairsAndFlexes", R"(<worldbody><geom name="a" size=".1"/><body><joint/><geom name="c" size=".1"/></body>
       <flexcomp name="cloth" type="grid" dim="2" count="3 3 1" spacing=".1 .1 .1" radius=".01" mass="1"><pin id="0"/></flexcomp></worldbody><contact><pair name="p" geom1="a" geom2="c"/></contact>)"},
};
// clang-format on

INSTANTIATE_TEST_SUITE_P(Constructs, MjcfReads, testing::ValuesIn(kRead), name_of_construct);
INSTANTIATE_TEST_SUITE_P(Constructs, MjcfRefuses, testing::ValuesIn(kRefused), name_of_construct);

/// Files beside the file: an included one, and a model attached with a prefix.
TEST(MjcfReads, FilesBesideTheFile_AreRead) {
  write_mjcf(R"(<default><default class="tip"><geom size=".02"/></default></default>
                <worldbody><body name="palm"><geom type="box" size=".1 .1 .02"/><body name="finger" pos="0 0 .1"><joint name="bend" axis="0 1 0"/><geom class="tip"/>
                </body></body></worldbody><actuator><position name="bend" joint="bend" kp="7"/></actuator>)",
             "hand.xml");
  write_mjcf(R"(<worldbody><body name="wrist" pos="0 0 1"><joint/><geom size=".1"/></body></worldbody>)", "wrist.xml");
  const fs::path file = write_mjcf(
      R"(<include file="wrist.xml"/><asset><model name="hand" file="hand.xml"/></asset>
         <worldbody><frame pos="1 0 0" euler="0 0 90"><attach model="hand" body="palm" prefix="left/"/></frame>
         <body name="right"><joint axis="1 0 0"/><geom size=".1"/><attach model="hand" body="palm" prefix="right/"/></body></worldbody>)",
      "two_hands.xml");
  EXPECT_TRUE(loads_or_names_why_not(file)) << message_of_file(file);
  const auto model = make_model(file);
  EXPECT_EQ(model->n_a(), 4);
  EXPECT_EQ(model->stiffness()[model->joint_index("left_bend")], 7);
  EXPECT_EQ(model->stiffness()[model->joint_index("right_bend")], 7);
}

/// Models of the wheel in its whole folder; archives of it are unpacked by CMake.
TEST(MjcfOfTheWheel, EveryModel_LoadsOrIsRefusedByName) {
  std::vector<fs::path> files;
  for (const char* folder : {STICTION_MUJOCO_FOLDER, STICTION_MUJOCO_UNPACKED}) {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.path().extension() == ".xml") files.push_back(entry.path());
    }
  }
  std::multiset<std::string> loaded, refused;
  for (const auto& file : files) (loads_or_names_why_not(file) ? loaded : refused).insert(file.filename());
  EXPECT_EQ(loaded, (std::multiset<std::string>{"msh.xml"}));
  EXPECT_EQ(refused, (std::multiset<std::string>{"model.xml", "model_with_assetdir.xml", "model_with_assetdir.xml"}));
}

/// MuJoCo's own model of everything, without what is refused: the rest of it loads.
TEST(MjcfOfTheWheel, ModelWithoutWhatIsRefused_StandsWhereMujocoHasIt) {
  const Owned<mjSpec> spec = parse(fs::path(STICTION_MUJOCO_FOLDER) / "testdata" / "model.xml");
  ASSERT_NE(spec, nullptr);
  const Unsupported before = unsupported_elements(spec.get());
  for_each(spec.get(), mjOBJ_JOINT, [&](mjsElement* e) {
    mjsJoint* joint = mjs_asJoint(e);
    std::fill_n(joint->stiffness, mjNPOLY + 1, 0);
    if (joint->type == mjJNT_BALL) joint->type = mjJNT_HINGE;
  });
  for_each(spec.get(), mjOBJ_GEOM, [&](mjsElement* e) {
    mjsGeom* geom = mjs_asGeom(e);
    if (geom->type == mjGEOM_ELLIPSOID || geom->type == mjGEOM_HFIELD) geom->contype = geom->conaffinity = 0;
  });
  for_each(spec.get(), mjOBJ_EQUALITY, [&](mjsElement* e) { mjs_asEquality(e)->active = 0; });
  for_each(spec.get(), mjOBJ_TENDON, [&](mjsElement* e) { mjs_asTendon(e)->limited = mjLIMITED_FALSE; });
  std::vector<mjsElement*> removed;  // legs with joints cannot hang on a free body; not on a joint
  removed.push_back(mjs_firstChild(mjs_findBody(spec.get(), "head"), mjOBJ_JOINT, false));
  for_each(spec.get(), mjOBJ_ACTUATOR, [&](mjsElement* e) {
    if (mjs_asActuator(e)->trntype != mjTRN_JOINT) removed.push_back(e);
  });
  for_each(spec.get(), mjOBJ_KEY, [&](mjsElement* e) { removed.push_back(e); });
  for (mjsElement* e : removed) ASSERT_EQ(mjs_delete(spec.get(), e), 0);

  const fs::path file = stiction::test::folder_of_the_process() / "model_without.xml";
  char error[1000] = "";
  const Owned<mjModel> compiled(mj_compile(spec.get(), nullptr));
  ASSERT_NE(compiled, nullptr) << mjs_getError(spec.get());
  ASSERT_EQ(mj_saveXML(spec.get(), file.c_str(), error, sizeof(error)), 0) << error;
  EXPECT_GT(before.refused.size() + before.passed.size(), 10u);
  EXPECT_TRUE(loads_or_names_why_not(file)) << message_of_file(file);
  const auto model = make_model(file);
  EXPECT_EQ(model->n_a(), compiled->njnt - 4) << "four free bodies";
}

}  // namespace
}  // namespace stiction::world::test
