'use strict';
(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const { scene, walk, methods, frames } = data;
  const byId = (id) => document.getElementById(id);
  const frameCount = frames.eye.length;

  // -- small helpers ------------------------------------------------------------------------------------------------
  const element = (tag, attributes = {}, ...children) => {
    const made = document.createElement(tag);
    for (const [key, value] of Object.entries(attributes)) {
      if (key === 'class') made.className = value;
      else made.setAttribute(key, value);
    }
    made.append(...children.filter((child) => child !== null));
    return made;
  };
  const grouped = new Intl.NumberFormat('en', { maximumFractionDigits: 0 });
  const whole = (value) => (value === null ? '–' : grouped.format(value));
  const one = (value) => (value === null ? '–' : value >= 1000 ? whole(value) : value.toFixed(1));
  const time = (value) => (value === null ? '–' : value >= 100 ? value.toFixed(0) : value >= 1 ? value.toFixed(2) : value.toFixed(4));
  const percent = (value) => (value * 100).toFixed(1) + ' %';
  const times = (value) => (value === null ? '–' : value.toFixed(2) + ' ×');
  const plural = (count, word) => `${whole(count)} ${word}${count === 1 ? '' : 's'}`;
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
  const safe = (method) => method.guarantee === 'exact' || method.guarantee === 'conservative';
  const drawn = walk.renderer !== '';

  const promises = {
    exact: 'reports what is visible and nothing else',
    conservative: 'reports everything that is visible, and perhaps more: no pixel may be lost',
    aggressive: 'reports only what is visible, perhaps not all of it: pixels may be lost, and are counted',
    approximate: 'promises neither that all that is reported is visible nor that all that is visible is reported',
  };

  // -- verdict and facts --------------------------------------------------------------------------------------------
  const fillHead = () => {
    byId('title').textContent = scene.name;
    byId('subtitle').textContent = `${plural(frameCount, 'frame')} of ${walk.width} × ${walk.height} pixels; the camera ${walk.path}.`;
    const broken = methods.filter((method) => safe(method) && method.false_invisible_pixels > 0);
    const losing = methods.filter((method) => !safe(method) && method.false_invisible_pixels > 0);
    const verdict = (kind, title, text) =>
      byId('verdict').append(element('p', { class: 'verdict ' + kind }, element('strong', {}, title), text));
    for (const method of broken)
      verdict('bad', `${method.name} broke its promise`,
        `It is ${method.guarantee}, but lost ${plural(method.false_invisible_pixels, 'confirmed pixel')} of ` +
        `${plural(method.false_invisible_objects, 'object')}. Please report this.`);
    for (const method of losing)
      verdict('warn', `${method.name} lost ${plural(method.false_invisible_pixels, 'pixel')} in ${plural(frameCount, 'frame')}`,
        `That is ${(method.false_invisible_pixels / walk.truth_pixels * 100).toPrecision(2)} % of all pixels. It is ` +
        `${method.guarantee}: it ${promises[method.guarantee]}.`);
    if (broken.length === 0 && losing.length === 0)
      verdict('good', 'No visible pixel was lost',
        `No method hid an object that one of the ${whole(walk.truth_pixels)} pixels of the walk sees.`);
    const fastest = (list) => list.filter((method) => method.speedup_over_frustum > 1.02 && !method.name.startsWith('frustum'))
      .sort((a, b) => b.speedup_over_frustum - a.speedup_over_frustum)[0];
    const winner = fastest(methods), clean = fastest(methods.filter((method) => method.false_invisible_pixels === 0));
    for (const method of clean && clean !== winner ? [clean, winner] : winner ? [winner] : [])
      verdict(method.false_invisible_pixels === 0 ? 'good' : 'warn',
        `${method.name} makes frames ${method.speedup_over_frustum.toFixed(2)} times as fast as frustum culling does` +
          (method.false_invisible_pixels === 0 ? ', without loss' : ', with loss'),
        `It hides ${percent(method.culled_of_frustum)} of the objects in view` +
        (walk.ceiling_speedup ? `; drawing only what is seen, culled for free, would be ${walk.ceiling_speedup.toFixed(2)} times as fast.` : '.'));

    const facts = [
      ['Objects', whole(scene.objects)], ['Triangles', whole(scene.triangles)],
      ['Extent', scene.extent.map((x) => Number(x.toPrecision(4))).join(' × ')],
      ['Seen per frame', `${one(walk.objects_true)} objects`],
      ['Truth', `${whole(walk.truth_pixels)} rays in double precision`],
      ['Drawing', drawn ? walk.renderer : 'not measured'],
    ];
    if (data.pvs) facts.push(['Baked file', `${data.pvs.method}, ${data.pvs.guarantee}`],
      ['Cells', `${whole(data.pvs.baked)} of ${whole(data.pvs.cells)} baked`], ['File size', `${whole(data.pvs.bytes)} bytes`]);
    facts.push(['Scene fingerprint', scene.fingerprint]);
    for (const [name, value] of facts) byId('facts').append(element('div', {}, element('dt', {}, name), element('dd', {}, value)));
    for (const note of walk.notes) byId('notes').append(element('li', {}, note));
  };

  // -- the table ----------------------------------------------------------------------------------------------------
  const fillMethods = () => {
    const table = byId('methods');
    table.append(element('caption', { class: 'hidden-visually' }, 'Methods of culling, their times and their quality'));
    const groups = element('tr', {}, element('th', {}), element('th', { colspan: 4, scope: 'colgroup' }, 'time, ms'),
      element('th', { colspan: 4, scope: 'colgroup' }, 'per frame'), element('th', { colspan: 3, scope: 'colgroup' }, 'over the walk'));
    const names = ['method', 'cull median', 'cull p99', 'draw median', 'frame median', 'objects reported', 'triangles drawn',
      'culled of frustum', 'false visible', 'objects lost', 'pixels lost', 'speed-up'];
    const head = element('tr');
    for (const name of names) head.append(element('th', { scope: 'col' }, name));
    table.append(element('thead', {}, groups, head));
    const body = element('tbody');
    for (const method of methods) {
      const lost = method.false_invisible_pixels;
      const kind = lost === 0 ? 'good' : safe(method) ? 'bad' : 'warn';
      body.append(element('tr', {},
        element('th', { scope: 'row' }, method.name, element('small', {}, method.guarantee)),
        element('td', {}, time(method.cull_ms.median)), element('td', {}, time(method.cull_ms.p99)),
        element('td', {}, time(method.draw_ms.median)), element('td', {}, time(method.frame_ms.median)),
        element('td', {}, one(method.objects_reported)), element('td', {}, whole(method.triangles_drawn)),
        element('td', {}, percent(method.culled_of_frustum)), element('td', {}, one(method.false_visible_objects)),
        element('td', { class: kind }, whole(method.false_invisible_objects)), element('td', { class: kind }, whole(lost)),
        element('td', {}, times(method.speedup_over_frustum))));
    }
    const reference = (name, remark, draw, objects, triangles, speedup) => element('tr', { class: 'reference' },
      element('th', { scope: 'row' }, name, element('small', {}, remark)), element('td', {}, '–'), element('td', {}, '–'),
      element('td', {}, time(draw)), element('td', {}, time(draw)), element('td', {}, one(objects)), element('td', {}, whole(triangles)),
      element('td', {}, '–'), element('td', {}, '0'), element('td', {}, '–'), element('td', {}, '–'), element('td', {}, times(speedup)));
    if (drawn) {
      body.append(reference('ceiling', 'only what is seen', walk.ceiling_ms, walk.objects_true, walk.triangles_true, walk.ceiling_speedup));
      body.append(reference('empty frame', 'nothing', walk.empty_ms, 0, 0, null));
    }
    table.append(body);
  };

  // -- plots --------------------------------------------------------------------------------------------------------
  let plots = [];
  let currentFrame = 0;
  const xs = Array.from({ length: frameCount }, (_, f) => f);
  const sum = (a, b) => a.map((value, f) => (value === null || b[f] === null ? null : value + b[f]));
  const plotSpecs = () => {
    const series = (key, digits) => methods.map((method, m) => ({ label: method.name, values: frames[key][m], colour: m, digits }));
    const specs = [];
    if (drawn) {
      specs.push({ title: 'Frame time, ms (culling and drawing)', series: [
        ...methods.map((method, m) => ({ label: method.name, values: sum(frames.cull[m], frames.draw[m]), colour: m, digits: 2 })),
        { label: 'ceiling', values: frames.ceiling, dash: [2, 4], digits: 2 }] });
    }
    specs.push({ title: 'Culling time, ms (logarithmic)', logarithmic: true,
      series: series('cull', 4).map((one) => ({ ...one, values: one.values.map((ms) => (ms > 0 ? ms : null)) })) });
    specs.push({ title: 'Triangles drawn', series: [...series('triangles', 0),
      { label: 'seen', values: frames.triangles_true, dash: [2, 4], digits: 0 }] });
    specs.push({ title: 'Objects reported', series: [...series('reported', 0),
      { label: 'seen', values: frames.objects_true, dash: [2, 4], digits: 0 }] });
    return specs;
  };
  // A line at the frame that the plan shows.
  const markFrame = (plot) => {
    const x = plot.valToPos(currentFrame, 'x', true);
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.strokeStyle = colour('accent');
    ctx.setLineDash([]);
    ctx.globalAlpha = 0.6;
    ctx.lineWidth = devicePixelRatio;
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.restore();
  };
  const short = (value) => (value >= 1e6 ? value / 1e6 + ' M' : value >= 1e4 ? value / 1e3 + ' k' : String(value));
  const drawPlots = () => {
    for (const plot of plots) plot.destroy();
    plots = [];
    drawStudyPlots();
    const place = byId('plots');
    place.replaceChildren();
    const sync = uPlot.sync('frames');
    for (const spec of plotSpecs()) {
      const box = element('div', { class: 'plot' }, element('h3', {}, spec.title));
      place.append(box);
      const axis = { stroke: colour('muted'), grid: { stroke: colour('line'), width: 1 }, ticks: { stroke: colour('line'), width: 1 } };
      // Lines at the powers of ten only.
      const decades = (u, ticks) => ticks.map((tick) => (Math.abs(Math.log10(tick) - Math.round(Math.log10(tick))) < 1e-9 ? tick : null));
      const yAxis = spec.logarithmic ? { ...axis, grid: { ...axis.grid, filter: decades }, ticks: { ...axis.ticks, filter: decades } } : axis;
      const plot = new uPlot({
        width: box.clientWidth - 16, height: 220, cursor: { sync: { key: sync.key }, drag: { x: true, y: false } },
        scales: { x: { time: false }, y: spec.logarithmic ? { distr: 3 } : { range: (u, low, high) => [0, high > 0 ? high * 1.05 : 1] } },
        axes: [{ ...axis, incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1e3, 2e3, 5e3, 1e4, 1e5] }, { ...yAxis, size: 62, values: (u, ticks) => ticks.map((tick) => (tick === null ? '' : short(tick))) }],
        hooks: { draw: [markFrame] },
        series: [{ label: 'frame' }, ...spec.series.map((one) => ({
          label: one.label, stroke: one.dash ? colour('muted') : colour('series-' + one.colour % 8), width: 1.5, dash: one.dash,
          points: { show: frameCount < 3 }, value: (u, v) => (v === null ? '–' : one.digits ? v.toFixed(one.digits) : whole(v)),
        }))],
      }, [xs, ...spec.series.map((one) => one.values)], box);
      plot.over.addEventListener('click', () => { if (plot.cursor.idx !== null) showFrame(plot.cursor.idx); });
      plots.push(plot);
    }
  };

  // -- studies: published figures beside ours -----------------------------------------------------------------------
  const fillStudies = () => {
    data.studies.forEach((study, s) => {
      const section = element('section', { class: 'study', 'aria-labelledby': `study-${s}` }, element('h2', { id: `study-${s}` }, study.title),
        element('p', { class: 'lead' }, 'After ', element('cite', {}, study.source), '. Rows marked “published” are quoted from it; all others were measured here.'));
      for (const paragraph of study.text.split(/\n\s*\n/)) if (paragraph.trim()) section.append(element('p', {}, paragraph.trim()));
      study.tables.forEach((table, t) => {
        const words = table.columns.map((_, c) => table.rows.some((row) => typeof row.cells[c] === 'string') ? 'words' : '');
        const head = element('tr');
        table.columns.forEach((column, c) => head.append(element('th', { scope: 'col', class: words[c] }, column.title + (column.unit ? `, ${column.unit}` : ''))));
        head.append(element('th', { scope: 'col', class: 'words' }, 'figures'));
        const body = element('tbody');
        for (const row of table.rows) {
          const line = element('tr', { class: row.origin });
          row.cells.forEach((cell, c) => {
            const shown = cell === null ? '–' : typeof cell === 'string' ? cell : cell.toLocaleString('en', { minimumFractionDigits: table.columns[c].digits, maximumFractionDigits: table.columns[c].digits });
            line.append(element(c === 0 ? 'th' : 'td', c === 0 ? { scope: 'row' } : { class: words[c] }, shown));
          });
          line.append(element('td', { class: 'words' }, row.origin));
          body.append(line);
        }
        section.append(element('h3', { id: `study-${s}-${t}` }, table.title));
        if (table.note) section.append(element('p', { class: 'muted' }, table.note));
        section.append(element('div', { class: 'scroll', role: 'region', 'aria-labelledby': `study-${s}-${t}`, tabindex: 0 },
          element('table', {}, element('thead', {}, head), body)));
      });
      section.append(element('div', { class: 'study-plots', id: `study-plots-${s}` }));
      for (const picture of study.pictures)
        section.append(element('figure', {}, element('img', { src: 'data:image/png;base64,' + picture.png, alt: picture.caption }), element('figcaption', {}, picture.caption)));
      if (study.notes.length) section.append(element('ul', { class: 'muted' }, ...study.notes.map((note) => element('li', {}, note))));
      byId('studies').append(section);
    });
  };
  // Lines of a plot may have places of their own: the union of all, gaps bridged.
  let studyPlots = [];
  const drawStudyPlots = () => {
    for (const plot of studyPlots) plot.destroy();
    studyPlots = [];
    data.studies.forEach((study, s) => {
      const place = byId(`study-plots-${s}`);
      place.replaceChildren();
      for (const spec of study.plots) {
        const box = element('div', { class: 'plot' }, element('h3', {}, spec.title));
        place.append(box);
        const places = [...new Set(spec.series.flatMap((one) => one.x))].sort((a, b) => a - b);
        const values = spec.series.map((one) => {
          const known = new Map(one.x.map((x, k) => [x, one.y[k]]));
          return places.map((x) => (known.has(x) ? known.get(x) : undefined));
        });
        const axis = { stroke: colour('muted'), grid: { stroke: colour('line'), width: 1 }, ticks: { stroke: colour('line'), width: 1 } };
        const number = (v) => (v === null || v === undefined ? '–' : Number(v.toPrecision(4)).toLocaleString('en'));
        studyPlots.push(new uPlot({
          width: box.clientWidth - 16, height: 240,
          scales: { x: { time: false, distr: spec.logarithmic_x ? 3 : 1 }, y: spec.logarithmic_y ? { distr: 3 } : { range: (u, low, high) => [Math.min(0, low), high > 0 ? high * 1.05 : 1] } },
          axes: [{ ...axis, label: spec.x_title }, { ...axis, label: spec.y_title, size: 62 }],
          series: [{ label: spec.x_title, value: (u, v) => number(v) }, ...spec.series.map((one, k) => ({
            label: one.label + (one.origin === 'published' ? ' (published)' : ''), stroke: colour('series-' + k % 8), width: 1.5,
            dash: one.origin === 'published' ? [6, 4] : undefined, points: { show: places.length < 60 }, value: (u, v) => number(v), spanGaps: false }))],
        }, [places, ...values], box));
      }
    });
  };

  // -- the plan -----------------------------------------------------------------------------------------------------
  const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const snapshots = data.snapshots.map((snapshot) => ({
    frame: snapshot.frame, seen: bytesOf(snapshot.seen), reported: snapshot.reported.map(bytesOf) }));
  const frustum = methods.findIndex((method) => method.name === 'frustum');
  const has = (bits, object) => (bits[object >> 3] >> (object & 7)) & 1;
  const NOTHING = -1;
  // Runs of (object and shade, length) to two arrays of pixels.
  const decodePlan = (plan) => {
    const bytes = bytesOf(plan.runs), object = new Int32Array(plan.width * plan.height), shade = new Uint8Array(object.length);
    let at = 0, pixel = 0;
    const next = () => {
      let value = 0, scale = 1, byte;
      do { byte = bytes[at++]; value += (byte & 127) * scale; scale *= 128; } while (byte & 128);
      return value;
    };
    while (pixel < object.length && at < bytes.length) {
      const value = next(), length = next();
      object.fill(value === 0 ? NOTHING : Math.floor((value - 1) / 8), pixel, pixel + length);
      shade.fill(value === 0 ? 0 : (value - 1) % 8, pixel, pixel + length);
      pixel += length;
    }
    return { object, shade };
  };
  const plans = data.plans.map((plan) => ({ ...plan, ...decodePlan(plan) }));
  const states = [
    { key: 'seen', name: 'drawn and seen', note: 'in a pixel of the truth' },
    { key: 'wasted', name: 'drawn for nothing', note: 'false visible' },
    { key: 'culled', name: 'culled in view', note: 'in the frustum, not drawn' },
    { key: 'lost', name: 'lost', note: 'seen, but not drawn: includes pixels that only graze an edge' },
    { key: 'outside', name: 'out of view', note: 'outside the frustum, not drawn' },
  ];
  const stateOf = (snapshot, m, object) => {
    const reported = has(snapshot.reported[m], object), seen = has(snapshot.seen, object);
    if (reported) return seen ? 0 : 1;
    if (seen) return 3;
    return has(snapshot.reported[frustum], object) ? 2 : 4;
  };
  const rgb = (name) => {
    const text = colour(name);
    return [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16));
  };
  const nearestSnapshot = (f) => snapshots.reduce((best, s) => (Math.abs(s.frame - f) < Math.abs(best.frame - f) ? s : best), snapshots[0]);
  const paintPlan = () => {
    if (plans.length === 0 || snapshots.length === 0) return;
    const m = Number(byId('plan-method').value), snapshot = nearestSnapshot(currentFrame), f = snapshot.frame;
    const plan = plans[frames.plan[f]], canvas = byId('plan');
    canvas.width = plan.width;
    canvas.height = plan.height;
    const context = canvas.getContext('2d'), image = context.createImageData(plan.width, plan.height), pixels = image.data;
    const palette = states.map((state) => rgb(state.key)), ground = rgb('card'), cut = rgb('cut'), counts = [0, 0, 0, 0, 0];
    const state = new Uint8Array(scene.objects);
    for (let object = 0; object < scene.objects; ++object) ++counts[state[object] = stateOf(snapshot, m, object)];
    for (let p = 0; p < plan.object.length; ++p) {
      const object = plan.object[p];
      let base = ground, share = 1;
      if (object !== NOTHING) {
        base = palette[state[object]];
        const level = plan.shade[p];
        share = level === 7 ? 0.6 : 0.45 + 0.55 * level / 6;
        for (let k = 0; k < 3; ++k) pixels[4 * p + k] = level === 7 ? base[k] * 0.45 + cut[k] * 0.55 : base[k] * share + ground[k] * (1 - share);
      } else for (let k = 0; k < 3; ++k) pixels[4 * p + k] = ground[k];
      pixels[4 * p + 3] = 255;
    }
    context.putImageData(image, 0, 0);
    const toX = (x) => (x - plan.x) / plan.scale, toY = (z) => (z - plan.z) / plan.scale;
    const size = Math.max(plan.width, plan.height);
    context.lineJoin = 'round';
    if (data.pvs && frames.cell[f]) {
      const [x0, z0, x1, z1] = frames.cell[f];
      context.strokeStyle = colour('ink');
      context.setLineDash([6, 4]);
      context.lineWidth = 1.5;
      context.strokeRect(toX(x0), toY(z0), toX(x1) - toX(x0), toY(z1) - toY(z0));
      context.setLineDash([]);
    }
    context.strokeStyle = colour('ink');
    context.globalAlpha = 0.75;
    context.lineWidth = 1.5;
    context.beginPath();
    frames.eye.forEach(([x, z], k) => (k ? context.lineTo(toX(x), toY(z)) : context.moveTo(toX(x), toY(z))));
    context.stroke();
    // The view from above: its opening to both sides of where the camera looks.
    const [x, z] = frames.eye[f], [dx, dz] = frames.direction[f], half = frames.opening[f], reach = size * 0.22;
    context.globalAlpha = 0.25;
    context.fillStyle = colour('accent');
    context.beginPath();
    context.moveTo(toX(x), toY(z));
    for (const side of [-1, 1]) {
      const way = [dx - side * dz * half, dz + side * dx * half], length = Math.hypot(...way) || 1;
      context.lineTo(toX(x) + way[0] / length * reach, toY(z) + way[1] / length * reach);
    }
    context.fill();
    context.globalAlpha = 1;
    context.beginPath();
    context.arc(toX(x), toY(z), Math.max(4, size / 110), 0, 7);
    context.fill();
    context.strokeStyle = colour('card');
    context.stroke();
    byId('plan-legend').replaceChildren(...states.map((one, k) => element('li', {},
      element('i', { style: `background:var(--${one.key})` }), element('span', {}, one.name), element('b', {}, whole(counts[k])),
      element('small', {}, one.note))));
    canvas.setAttribute('aria-label', `Plan at frame ${f}, method ${methods[m].name}: ` +
      states.map((one, k) => `${counts[k]} objects ${one.name}`).join(', '));
    byId('plan-frame-number').textContent = f;
  };
  function showFrame(f) {
    currentFrame = f;
    byId('plan-frame').value = f;
    paintPlan();
    for (const plot of plots) plot.redraw(false);
  }
  let player = 0;
  const play = () => {
    const button = byId('plan-play');
    if (player) { clearInterval(player); player = 0; }
    else player = setInterval(() => showFrame((currentFrame + 1) % frameCount), 120);
    button.textContent = player ? 'Stop' : 'Play';
    button.setAttribute('aria-pressed', String(player !== 0));
  };
  const choices = (select, names, chosen) => {
    names.forEach((name, k) => select.append(element('option', { value: k }, name)));
    select.value = chosen;
  };
  const interesting = () => {
    const k = methods.findLastIndex((method) => method.name !== 'none' && !method.name.startsWith('frustum'));
    return k >= 0 ? k : frustum;
  };
  const setUpPlan = () => {
    byId('plan-lead').textContent = (data.outdoors ? 'The scene from above. '
      : "The scene cut open a little above the viewer's eyes. Muted patches are solid matter that the cut runs through. ") +
      'Each object has the colour of what became of it at this frame' + (data.pvs ? '; the dashed frame is the baked cell.' : '.');
    choices(byId('plan-method'), methods.map((method) => method.name), interesting());
    byId('plan-frame').max = frameCount - 1;
    byId('plan-frame').addEventListener('input', (event) => showFrame(Number(event.target.value)));
    byId('plan-method').addEventListener('change', paintPlan);
    byId('plan-play').addEventListener('click', play);
  };

  // -- pictures -----------------------------------------------------------------------------------------------------
  const showPicture = () => {
    const picture = data.pictures[Number(byId('picture-frame').value)];
    const m = Number(byId('picture-method').value), other = picture.methods[m];
    const mode = document.querySelector('input[name=mode]:checked').value;
    const image = byId('picture');
    image.src = mode === 'on' ? other.on || picture.off : mode === 'difference' ? other.difference || picture.off : picture.off;
    image.classList.toggle('dim', mode === 'difference' && !other.difference);
    const name = methods[m].name, differ = other.differing_pixels;
    image.alt = mode === 'off' ? `Frame ${picture.frame} with every object drawn`
      : mode === 'on' ? `Frame ${picture.frame} drawn after culling by ${name}` : `Where the two pictures of frame ${picture.frame} differ`;
    const count = `${whole(frames.reported[m][picture.frame])} of ${whole(scene.objects)} objects, ${whole(frames.triangles[m][picture.frame])} triangles`;
    byId('picture-caption').textContent = (mode === 'off' ? `Frame ${picture.frame}, everything drawn: ${whole(scene.triangles)} triangles. `
      : mode === 'on' ? `Frame ${picture.frame}, drawn after ${name}: ${count}. ` : `Frame ${picture.frame}: pixels that differ are magenta. `) +
      (mode === 'off' ? '' : differ === 0 ? 'The two pictures are the same, pixel for pixel.' : `${plural(differ, 'pixel')} differ between the two pictures.`);
  };
  const setUpPictures = () => {
    byId('pictures-lead').textContent = drawn
      ? 'Drawn with OpenGL, with a colour per object; see-through objects are blended.'
      : 'There was no OpenGL: these are shaded from the rays of the truth, without see-through objects.';
    choices(byId('picture-frame'), data.pictures.map((picture) => `${picture.frame}: ${picture.why}`), 0);
    choices(byId('picture-method'), methods.map((method) => method.name), interesting());
    byId('picture-frame').addEventListener('change', showPicture);
    byId('picture-method').addEventListener('change', showPicture);
    byId('picture-mode').addEventListener('change', showPicture);
    showPicture();
  };

  // -- worst frames -------------------------------------------------------------------------------------------------
  const fillWorst = () => {
    const largest = (values) => values.reduce((best, value, f) => (value !== null && (best < 0 || value > values[best]) ? f : best), -1);
    const rows = [];
    methods.forEach((method, m) => {
      const slow = drawn ? sum(frames.cull[m], frames.draw[m]) : frames.cull[m];
      rows.push([method.name, 'slowest', largest(slow), (f) => `${time(slow[f])} ms`]);
      if (method.name !== 'none') rows.push([method.name, 'most false visible', largest(frames.false_visible[m]), (f) => plural(frames.false_visible[m][f], 'object')]);
      if (method.false_invisible_pixels > 0) {
        const worst = frames.lost[m].map((pixels, f) => [pixels, f]).filter(([pixels]) => pixels > 0).sort((a, b) => b[0] - a[0] || a[1] - b[1]);
        for (const [, f] of worst.slice(0, 5)) rows.push([method.name, 'pixels lost', f, (k) => plural(frames.lost[m][k], 'pixel')]);
      }
    });
    const head = element('tr');
    for (const [name, kind] of [['method', 'words'], ['what', 'words'], ['frame', ''], ['how much', ''], ['in frustum', ''], ['reported', ''], ['seen', '']])
      head.append(element('th', { scope: 'col', class: kind }, name));
    const body = element('tbody');
    for (const [name, what, f, amount] of rows) {
      if (f < 0) continue;
      const button = element('button', { type: 'button', 'aria-label': `Show frame ${f} from above` }, String(f));
      const m = methods.findIndex((method) => method.name === name);
      button.addEventListener('click', () => {
        byId('plan-method').value = m;
        showFrame(f);
        byId('plan-heading').scrollIntoView();
      });
      body.append(element('tr', {}, element('th', { scope: 'row' }, name), element('td', { class: 'words' }, what), element('td', {}, button),
        element('td', {}, amount(f)), element('td', {}, whole(frames.in_frustum[f])), element('td', {}, whole(frames.reported[m][f])),
        element('td', {}, whole(frames.objects_true[f]))));
    }
    byId('worst').append(element('thead', {}, head), body);
  };

  const fillReading = () => {
    const list = element('dl');
    const add = (name, text) => list.append(element('dt', {}, name), element('dd', {}, text));
    for (const guarantee of new Set(methods.map((method) => method.guarantee)))
      add(guarantee, `A method with this guarantee ${promises[guarantee]}.`);
    add('seen', `An object is seen at a frame if one of the ${walk.width * walk.truth_scale} × ${walk.height * walk.truth_scale} rays through the middles of the ` +
      'pixels meets it first, ties and see-through surfaces in front included. Objects that slip between the rays are not seen: a false visible object may in fact show a sliver.');
    add('pixels lost (false invisible)', 'Rays that see an object which the method did not report. Each was judged again in exact arithmetic; rays that only graze an edge do not count, since an edge has no area.');
    add('false visible', 'Objects reported that no ray sees: wasted work, never a hole in the picture. A baked set knows the cell, not the viewpoint, so it always has some.');
    add('culled of frustum', 'Share of the objects that view-frustum culling would draw and that the method does not. Mean over the frames.');
    add('ceiling', 'Drawing exactly the objects that are seen, with culling for free. No culling of whole objects can be faster on this scene, this path and this renderer.');
    add('draw time', drawn ? `From the first draw call until the renderer has finished (${walk.renderer}). One draw call per object; of ${plural(walk.repeat, 'walk')} the fastest counts, frame by frame, which is what the work takes when nothing else disturbs the machine. ` +
      'A graphics card has other costs per triangle, pixel and call: compare methods here, not with other machines.' : 'Not measured.');
    add('speed-up', 'Median frame time (culling and drawing) of frustum culling divided by that of the method.');
    byId('reading').append(list);
  };

  fillHead();
  fillMethods();
  fillStudies();
  setUpPlan();
  setUpPictures();
  fillWorst();
  fillReading();
  drawPlots();
  showFrame(data.pictures.length ? data.pictures[0].frame : 0);
  const redraw = () => { drawPlots(); paintPlan(); };
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  let width = innerWidth, pending = 0;
  addEventListener('resize', () => {
    if (innerWidth === width) return;
    width = innerWidth;
    clearTimeout(pending);
    pending = setTimeout(drawPlots, 150);
  });
  document.documentElement.dataset.ready = 'yes';
})();
