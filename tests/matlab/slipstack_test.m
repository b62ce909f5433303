% SPDX-License-Identifier: Apache-2.0
% slipstack.m in Octave, in a folder with log.csv (viscous friction hidden); run by run_octave.py.
function slipstack_test()
  found = slipstack('diagnose', 'log.csv', '--stepwise');
  assert(strcmp(found.verdict, 'missing_effect'));
  assert(strcmp(found.candidates(1).effect, 'viscous'));
  assert(strcmp(found.schema, 'urn:slipstack:diagnose-1'));
  assert(~isempty(strfind(found.text, 'viscous')));
  assert(found.steps{end}.holdout_rmse_N < 0.97 * found.baseline.holdout_rmse_N);

  fitted = slipstack('fit', 'log.csv', '--effects', {'inertia', 'presliding_hysteresis'}, '--model', 'axis''s model.toml');
  assert(exist('axis''s model.toml', 'file') == 2);
  better = slipstack('add', 'log.csv', '--model', 'axis''s model.toml', '--effect', 'viscous', '--out', 'better.toml');
  assert(better.holdout_rmse_N < fitted.holdout_rmse_N);
  checked = slipstack('compare', 'log.csv', '--model', 'better.toml');
  assert(abs(checked.rmse_N / better.train_rmse_N - 1) < 1e-9);

  % The same log from memory: the same numbers.
  [header, columns] = read_log('log.csv');
  columns.header = header;
  again = slipstack('compare', columns, '--model', 'better.toml');
  assert(again.rmse_N == checked.rmse_N);
  assert(again.samples == checked.samples);

  simulated = slipstack('simulate', 'better.toml', '--log', 'log.csv', '--start', 0.5);
  assert(simulated.summary.start_s == 0.5);
  listed = slipstack('effects');
  assert(isequal(fieldnames(listed), {'text'}) && ~isempty(strfind(listed.text, 'stribeck')));

  planned = slipstack('experiment plan', '--log', 'log.csv', '--for', 'stribeck', '--out', 'plan.csv');
  assert(strcmp(planned.schema, 'urn:slipstack:experiment-1') && planned.summary.duration_s > 0);
  looped = slipstack('loop', '--board', 'host', '--seconds', 8, '--out', 'loop.csv');
  assert(strcmp(looped.schema, 'urn:slipstack:loop-1') && exist('loop.csv', 'file') == 2);
  exported = slipstack('export', 'better.toml', '--c', 'friction.h');
  assert(isequal(fieldnames(exported), {'text'}) && exist('friction.h', 'file') == 2);
  every_command({}, whole_help());

  refused(@() slipstack('serve', 'log.csv'), 'slipstack:input', 'terminal');
  refused(@() slipstack('node', '--can', 'vcan0'), 'slipstack:input', 'terminal');
  refused(@() slipstack('status', '--can', 'none0', '--node', 5), 'slipstack:input', 'none0');
  refused(@() slipstack('diagnose', 'none.csv'), 'slipstack:input', 'none.csv');
  refused(@() slipstack('fit', 'log.csv'), 'slipstack:input', '--effects');
  refused(@() slipstack('diagnose', struct('time_s', [1 2 3], 'force_N', [1 2])), 'slipstack:input', 'force_N');
  refused(@() slipstack('diagnose', struct('header', struct())), 'slipstack:input', 'columns');
  refused(@() slipstack('diagnose', {1}), 'slipstack:input', 'argument');
  refused(@() slipstack(''), 'slipstack:input', 'command');
  left = [dir(fullfile(tempdir(), '*.csv')); dir(fullfile(tempdir(), '*.json'))];
  assert(isempty(left), 'temporary files are left');
  disp('octave: all asserted');
end

function text = whole_help()
  [status, text] = system([getenv('SLIPSTACK') ' --help']);
  assert(status == 0);
end

% The help of each command that a help names, and of those that its own names.
function every_command(before, help)
  list = regexp(help, 'Subcommands:\n((  .*\n)+?)\n', 'tokens', 'once', 'dotexceptnewline');
  if isempty(list)
    return;
  end
  names = regexp(list{1}, '^  ([a-z][a-z-]*)', 'tokens', 'lineanchors');
  assert(~isempty(names));
  for k = 1:numel(names)
    command = strjoin([before, names{k}], ' ');
    told = slipstack(command, '--help');
    assert(~isempty(strfind(told.text, ['slipstack ' command])), told.text);
    every_command([before, names{k}], told.text);
  end
end

function refused(call, identifier, word)
  try
    call();
  catch fault
    assert(strcmp(fault.identifier, identifier), fault.message);
    assert(~isempty(strfind(fault.message, word)), fault.message);
    assert(isempty(strfind(strtrim(fault.message), sprintf('\n'))), 'more than one line');
    return;
  end
  error('not refused: %s', word);
end

function [header, columns] = read_log(path)
  lines = strsplit(strtrim(fileread(path)), sprintf('\n'));
  comments = strncmp(lines, '#', 1);
  header = struct();
  for k = find(comments)
    parts = regexp(lines{k}, '^# *(\w+): *(.*)$', 'tokens', 'once');
    number = str2double(parts{2});
    if isnan(number)
      header.(parts{1}) = parts{2};
    else
      header.(parts{1}) = number;
    end
  end
  rest = lines(~comments);
  names = strsplit(strtrim(rest{1}), ',');
  table = cell2mat(cellfun(@(line) sscanf(line, '%f,')', rest(2:end)', 'UniformOutput', false));
  for k = 1:numel(names)
    columns.(names{k}) = table(:, k);
  end
end
