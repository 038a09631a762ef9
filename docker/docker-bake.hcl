# docker buildx bake -f docker/docker-bake.hcl            all three, for both machines
# docker buildx bake -f docker/docker-bake.hcl edge --set '*.platform=linux/arm64' --load
variable "IMAGE" { default = "qrobot" }
variable "RELEASE" { default = "trixie" }
# Pin the base by its digest for builds that shall be the same next year.
variable "BASE" { default = "docker.io/library/debian:${RELEASE}-slim" }
variable "VERSION" { default = "unknown" }
variable "REVISION" { default = "unknown" }
variable "SOURCE_DATE_EPOCH" { default = "0" }

group "default" { targets = ["solver", "edge", "lab"] }

target "image" {
  context = "."
  dockerfile = "docker/Dockerfile"
  platforms = ["linux/amd64", "linux/arm64"]
  args = {
    BASE = BASE
    VERSION = VERSION
    REVISION = REVISION
    SOURCE_DATE_EPOCH = SOURCE_DATE_EPOCH
  }
}

target "solver" {
  inherits = ["image"]
  target = "solver"
  tags = RELEASE == "trixie" ? ["${IMAGE}:solver", "${IMAGE}:solver-trixie"] : ["${IMAGE}:solver-${RELEASE}"]
}

target "edge" {
  inherits = ["image"]
  target = "edge"
  tags = RELEASE == "trixie" ? ["${IMAGE}:edge", "${IMAGE}:edge-trixie"] : ["${IMAGE}:edge-${RELEASE}"]
}

target "lab" {
  inherits = ["image"]
  target = "lab"
  tags = RELEASE == "trixie" ? ["${IMAGE}:lab", "${IMAGE}:lab-trixie"] : ["${IMAGE}:lab-${RELEASE}"]
}
