/// @file  The frames of the house, and how quantities between them are written.
///
/// - W: world, fixed in the laboratory; z **up**
/// - N: platform neutral, where the platform stands with all coordinates zero; x surge, y sway, z **down**
/// - B: platform body, moves with the ship; z **down**
/// - D: level frame, origin and heading of N; z **down** along gravity
/// - R: robot base, bolted to the platform; z up
/// - T: tool point, where the wire leaves the arm; axes as R
/// - M: motion reference unit; z **down**
/// - Q: camera system; z down
/// - P: tracked camera body on the platform
/// - L: load, a point
///
/// Monogram notation (Drake's): `p_WT` is the position of T from the origin of W, expressed in W; `R_WB`
/// turns coordinates of B into coordinates of W; `X_WB` is both. Where a vector is expressed in a third
/// frame, that frame stands behind: `v_WT_N`. Letters cancel: p_WT = R_WB p_BT + p_WB. At the doors (topics,
/// configuration, reports) the same is written out: `p_world_tool_m`.
#pragma once
