// What a tab keeps of its state in the browser. The entry of a tab lies in the local storage under the tab's own name,
// which lies in its session storage; a tab that is open holds a lock of that name. An entry without a lock belongs to a
// tab that is gone: if it has changes that were not saved, the next tab offers it. A tab that is loaded anew also has the
// secret by which the server gives its session back; a copy of a tab, whose name is held by the other one, does not use it.
window.cockpitRecovery = (() => {
  const PREFIX = 'epicyclic.tab.', LINK = 'epicyclic.link', SECRET = 'epicyclic.secret';
  const MOST_LEFT = 8, MOST_SECRETS = 4;  // entries of tabs that are gone, the newest; secrets of a tab
  const MOST_LINK = 100000;  // a longer one is refused anyhow, and need not be sent
  let own = null;
  const names = () => Object.keys(localStorage)
    .filter(key => key.startsWith(PREFIX)).map(key => key.slice(PREFIX.length));
  const entry = name => { try { return JSON.parse(localStorage.getItem(PREFIX + name)); } catch { return null; } };
  const hold = name => new Promise(resolve => {
    if (!navigator.locks) return resolve(true);
    navigator.locks.request(PREFIX + name, {ifAvailable: true}, lock => {
      resolve(lock !== null);
      return lock && new Promise(() => {});  // as long as the tab lives
    });
  });
  const named = async () => {
    const former = sessionStorage.getItem(PREFIX), fresh = crypto.randomUUID();
    if (former && await hold(former)) return [former, former];
    await hold(fresh);  // a new tab, or the copy of one that is open: it begins with the same state
    sessionStorage.setItem(PREFIX, fresh);
    return [fresh, former];
  };
  const left = async () => {
    if (!navigator.locks) return [];
    const held = new Set((await navigator.locks.query()).held.map(lock => lock.name));
    const gone = names().filter(name => name !== own && !held.has(PREFIX + name));
    const entries = gone.map(name => [name, entry(name)]).sort((a, b) => (b[1]?.time ?? 0) - (a[1]?.time ?? 0));
    const kept = entries.filter(([, value]) => value && value.unsaved).slice(0, MOST_LEFT);
    entries.filter(pair => !kept.includes(pair)).forEach(([name]) => drop(name));
    return kept.map(([name, value]) => ({name, time: value.time, title: value.title}));
  };
  const drop = name => localStorage.removeItem(PREFIX + name);
  addEventListener('hashchange', () => location.reload());  // a link put into the address of an open tab
  return {
    drop,
    take: name => entry(name)?.snapshot ?? null,
    // whether it is kept; an empty snapshot is of no state, or of one that is too large
    keep: (snapshot, title, unsaved) => {
      if (own === null) return null;
      sessionStorage.removeItem(LINK);
      try {
        if (!snapshot) throw new RangeError('too large');
        localStorage.setItem(PREFIX + own, JSON.stringify({snapshot, title, unsaved, time: Date.now()}));
        return true;
      } catch {
        drop(own);  // an old state would come back for the new one
        return false;
      }
    },
    begin: async secret => {
      const link = location.hash.slice(1, MOST_LINK) || sessionStorage.getItem(LINK) || '';
      if (link) sessionStorage.setItem(LINK, link);  // until what it opens is kept
      history.replaceState(null, '', '/');
      const [name, former] = await named();
      own = name;
      // those before too: a page that was left at once has not used them
      const secrets = name === former ? (sessionStorage.getItem(SECRET) ?? '').split(' ').filter(Boolean) : [];
      sessionStorage.setItem(SECRET, [secret, ...secrets].slice(0, MOST_SECRETS).join(' '));
      return {link, secrets, snapshot: former ? entry(former)?.snapshot ?? null : null, left: await left()};
    },
  };
})();
