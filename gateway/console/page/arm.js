// Where the arm's joints are, from its own kinematics. Joint 1 turns clockwise seen from above, joint 3 is measured
// against the vertical; the wrist is in line with the forearm.

// Points in the robot's base (z up), from the floor of the base to the tool.
export function armPoints(arm, q) {
  const [s2, c2, s3, c3] = [Math.sin(q[1]), Math.cos(q[1]), Math.sin(q[2]), Math.cos(q[2])];
  const at = (rho, z) => [Math.cos(q[0]) * rho, -Math.sin(q[0]) * rho, z];
  const shoulder = [arm.a1_m, arm.d1_m];
  const elbow = [shoulder[0] + arm.a2_m * s2, shoulder[1] + arm.a2_m * c2];
  const forearm = [elbow[0] - arm.a3_m * c3, elbow[1] - arm.a3_m * s3];
  const along = length => [forearm[0] - length * s3, forearm[1] + length * c3];
  return {
    base: at(0, 0),
    waist: at(0, arm.d1_m),
    shoulder: at(...shoulder),
    elbow: at(...elbow),
    forearm: at(...forearm),
    wrist: at(...along(0.7 * arm.reach_m)),
    tool: at(...along(arm.reach_m)),
  };
}
