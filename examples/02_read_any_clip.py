"""Read a motion file, see what was detected, edit it, and write it in another format."""

import understudy as us

# A file to read; any BVH, AMC with ASF, AMASS .npz or table of orientations is read the same way.
us.write(us.sample("walk"), "walk.bvh")

clip = us.read("walk.bvh")
print(f"{clip.name}: {len(clip.skeleton)} joints, {clip.frames} frames, {clip.rate:g} Hz")
for note in clip.notes:  # vertical axis, unit, T-pose, repairs: what the file did not say
    print(" ", note)

second = clip.trimmed(1.0, 2.0).resampled(30.0)
left_knee = second.joint("left_knee")  # local rotations, quaternions wxyz, shape (frames, 4)
print(f"{second.duration:.1f} s of it at {second.rate:g} Hz; left knee {left_knee.shape}")

pose = second.forward_kinematics()  # world, meters, z up
ankle = pose.positions[:, clip.skeleton.index("left_ankle")]
print(f"the left ankle rises to {ankle[:, 2].max():.2f} m")

us.write(second, "second.glb", "second.csv")
