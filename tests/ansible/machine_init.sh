#!/bin/sh
# The inside of a machine: run by machine.py in namespaces of its own (mount, process, network,
# host name, IPC and cgroup). Mounts what systemd wants and becomes it.
# Usage: machine_init.sh LOWER FOLDER   LOWER: the bare system; FOLDER: a mount point, and what is laid over it
set -eu
lower=$1 root=$2/root more=$2/more
mount --make-rprivate /
# What is written lies in memory and goes with the machine.
mkdir -p "$root"
mount -t tmpfs -o size=8g,mode=755 tmpfs "$root"
mkdir "$root/upper" "$root/work" "$root/system"
mount -t overlay -o "lowerdir=$more:$lower,upperdir=$root/upper,workdir=$root/work" overlay "$root/system"
root=$root/system
mount -t proc proc "$root/proc"
# The kernel is the computer's: nothing in the machine may set it.
mount --bind "$root/proc/sys" "$root/proc/sys"
mount -o remount,bind,ro "$root/proc/sys"
mount -t sysfs -o ro sysfs "$root/sys"
mount -t cgroup2 cgroup2 "$root/sys/fs/cgroup"
mount -t tmpfs -o mode=755 tmpfs "$root/dev"
mkdir "$root/dev/pts" "$root/dev/shm" "$root/dev/mqueue"
mount -t devpts -o newinstance,ptmxmode=0666,mode=0620,gid=5 devpts "$root/dev/pts"
mount -t tmpfs -o mode=1777 tmpfs "$root/dev/shm"
ln -s pts/ptmx "$root/dev/ptmx"
ln -s /proc/self/fd "$root/dev/fd"
for device in null:3 zero:5 full:7 random:8 urandom:9; do
  mknod -m 666 "$root/dev/${device%:*}" c 1 "${device#*:}"
done
mknod -m 666 "$root/dev/tty" c 5 0
mount -t tmpfs -o mode=755 tmpfs "$root/run"
mount -t tmpfs -o mode=1777 tmpfs "$root/tmp"
ip link set lo up
hostname robot
cd "$root"
mkdir -p mnt/before
pivot_root . mnt/before
# No clock, no modules, no devices of the computer.
exec setpriv --bounding-set=-sys_time,-sys_module,-sys_rawio,-syslog,-sys_boot \
  sh -c 'umount -l /mnt/before && exec env -i container=qrobot-test TERM=dumb PATH=/usr/sbin:/usr/bin:/sbin:/bin /sbin/init' \
  </dev/null >/dev/null 2>&1
