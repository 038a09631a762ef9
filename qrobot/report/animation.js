"use strict";
(() => {
  const find = (id) => document.getElementById(id);
  const plan = JSON.parse(find("plan").dataset.plan);
  const play = find("play"), slider = find("time"), clock = find("clock"), speed = find("speed"), told = find("told");
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  const ways = [...document.querySelectorAll(".trip")];
  let now = 0, last = null;

  // Of sorted numbers, how many are at most x.
  const passed = (numbers, x) => {
    let low = 0, high = numbers.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (numbers[middle] <= x) low = middle + 1; else high = middle;
    }
    return low;
  };

  const trips = plan.robots.flatMap((robot) => robot.trips);
  const time = (seconds) => {
    const whole = Math.floor(seconds), part = String(whole % 60).padStart(2, "0");
    const hours = Math.floor(whole / 3600), minutes = Math.floor(whole / 60) % 60;
    return hours ? `${hours}:${String(minutes).padStart(2, "0")}:${part}` : `${minutes}:${part}`;
  };

  // Draw what the robot has passed of its way over the whole way, which is paler.
  const trail = (trip) => {
    const line = document.createElementNS("http://www.w3.org/2000/svg", "polyline");
    line.setAttribute("class", "trail");
    line.setAttribute("points", trip.x.map((x, k) => `${x},${trip.y[k]}`).join(" "));
    line.setAttribute("stroke", trip.fill);
    ways[trip.way].querySelector(".way").after(line);
    return line;
  };

  for (const trip of trips) {
    trip.along = [0];
    for (let k = 1; k < trip.t.length; k++) {
      trip.along.push(trip.along[k - 1] + Math.hypot(trip.x[k] - trip.x[k - 1], trip.y[k] - trip.y[k - 1]));
    }
    trip.trail = trail(trip);
    trip.marks = [...ways[trip.way].querySelectorAll(".mark")];
  }

  // Where a robot is on a trip at a moment: coordinates, and the way that it has passed.
  const place = (trip, moment) => {
    const k = Math.min(Math.max(passed(trip.t, moment), 1), trip.t.length - 1);
    const from = trip.t[k - 1], span = trip.t[k] - from;
    const share = span > 0 ? Math.min(Math.max((moment - from) / span, 0), 1) : moment >= trip.t[k] ? 1 : 0;
    const between = (list) => list[k - 1] + (list[k] - list[k - 1]) * share;
    return [between(trip.x), between(trip.y), between(trip.along)];
  };

  // What a robot does: a sentence, its load, and how much it has picked on this trip.
  const doing = (trip, moment) => {
    const reached = passed(trip.arrives, moment), done = passed(trip.leaves, moment);
    const load = done ? trip.loads[done - 1] : "0";
    if (moment >= trip.end) return ["at the depot", load, done];
    if (reached > done) return [`picks ${trip.labels[done]}`, load, done];
    return [done < trip.labels.length ? `on its way to ${trip.labels[done]}` : "on its way to the depot", load, done];
  };

  const show = () => {
    plan.robots.forEach((robot, number) => {
      const started = robot.trips.filter((one) => one.start <= now);
      const trip = started[started.length - 1] || robot.trips[0];
      for (const one of robot.trips) {
        const phase = now < one.start ? -1 : now >= one.end ? 1 : 0;
        if (phase && phase === one.phase) continue; // nothing has changed
        one.phase = phase;
        // Who wants little motion sees robots jump from stop to stop.
        const stops = passed(one.arrives, now), taken = passed(one.leaves, now);
        const moment = !calm.matches || now >= one.end ? now : stops ? one.leaves[stops - 1] : one.start;
        const [x, y, along] = place(one, moment);
        one.trail.setAttribute("stroke-dasharray", `${along} ${one.along[one.along.length - 1] + 1}`);
        one.trail.style.visibility = along > 0 ? "visible" : "hidden";
        if (taken !== one.taken) one.marks.forEach((mark, k) => mark.classList.toggle("done", one.marked[k] <= now));
        one.taken = taken;
        if (one === trip) {
          const marker = find(`robot-${number}`);
          marker.setAttribute("transform", `translate(${x} ${y})`);
          marker.setAttribute("fill", one.fill);
          marker.setAttribute("stroke", one.edge);
          marker.lastElementChild.setAttribute("fill", one.text);
        }
      }
      const [does, load, done] = doing(trip, now);
      const earlier = robot.trips.slice(0, robot.trips.indexOf(trip)).reduce((sum, one) => sum + one.labels.length, 0);
      find(`does-${number}`).textContent = does;
      find(`load-${number}`).textContent = `${load} of ${robot.capacity}`;
      find(`done-${number}`).textContent = `${earlier + done} of ${robot.picks}`;
    });
    slider.value = String(now);
    clock.textContent = `${time(now)} of ${time(plan.end)}`;
    slider.setAttribute("aria-valuetext", clock.textContent);
  };

  const step = (stamp) => {
    if (last === null) return;
    // A frame may have begun before the button was pressed; a page that was hidden goes on where it was.
    const elapsed = Math.min(Math.max(stamp - last, 0), 250) / 1000;
    now = Math.min(plan.end, now + elapsed * Number(speed.value));
    last = stamp;
    show();
    if (now >= plan.end) pause(); else requestAnimationFrame(step);
  };
  const pause = () => {
    last = null;
    play.textContent = "Play";
    told.textContent = `Paused at ${clock.textContent}`;
  };
  const start = () => {
    if (now >= plan.end) now = 0;
    last = performance.now();
    play.textContent = "Pause";
    told.textContent = "Playing";
    requestAnimationFrame(step);
  };
  const go = (moment) => {
    now = Math.min(Math.max(moment, 0), plan.end);
    show();
  };

  play.addEventListener("click", () => (last === null ? start() : pause()));
  slider.addEventListener("input", () => go(Number(slider.value)));
  calm.addEventListener("change", show);
  document.addEventListener("keydown", (event) => {
    if (event.target.closest("button, select, input") || event.ctrlKey || event.altKey || event.metaKey) return;
    const keys = {
      " ": () => play.click(), ArrowLeft: () => go(now - plan.end / 50), ArrowRight: () => go(now + plan.end / 50),
      Home: () => go(0), End: () => go(plan.end),
    };
    if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
  });
  find("controls").hidden = find("hint").hidden = false;
  show();
})();
