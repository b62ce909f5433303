% SPDX-License-Identifier: Apache-2.0
function result = slipstack(command, varargin)
% SLIPSTACK  Runs a command of slipstack and returns its result as a struct.
%
%   found = slipstack('diagnose', 'log.csv');
%   found.verdict, found.candidates(1).effect
%   fitted = slipstack('fit', 'log.csv', '--effects', {'inertia', 'presliding_hysteresis'}, '--model', 'axis.toml');
%   plan = slipstack('experiment plan', '--for', 'viscous', '--log', 'log.csv', '--out', 'plan.csv');
%
% The arguments are those of the command line (slipstack COMMAND --help). A number is written with all its digits, a cell
% of texts as a list with commas, and a struct stands for a log: its fields are the columns, named as in a log file
% (time_s, position_m, force_N, ...), and a field `header`, if there is one, holds what `# key: value` lines say:
%
%   log = struct('time_s', t, 'position_m', x, 'force_N', F, 'header', struct('mass_kg', 35.45));
%   found = slipstack('diagnose', log, '--stepwise');
%
% The result has the keys of the command's JSON, and `text`, the table that the command line prints. Commands without
% JSON (effects, export, import, those of a controller) give `text` alone, as --help does. null becomes NaN or []. Input
% that cannot be used is an error slipstack:input with the line that the command line prints; slipstack:fault is a fault
% of the program. `serve` and `node`, which go on until Ctrl-C, are for a terminal.
%
% The program is found on the PATH, or named by the environment variable SLIPSTACK. MATLAB R2016b, Octave 7 or later.
  if nargin < 1 || ~ischar(command) || isempty(strtrim(command))
    error('slipstack:input', 'slipstack: name a command, as slipstack(''diagnose'', ''log.csv'')');
  end
  files = {};
  words = strsplit(strtrim(command));
  asked = varargin(cellfun(@ischar, varargin));
  help = any(strcmp(asked, '--help')) || any(strcmp(asked, '-h'));
  if any(strcmp(words{1}, {'serve', 'node'})) && ~help
    error('slipstack:input', 'slipstack: %s goes on until Ctrl-C; type it in a terminal', words{1});
  end
  with_json = gives_json(words) && ~help && ~any(strcmp(asked, '--json'));
  for k = 1:numel(varargin)
    if isstruct(varargin{k})
      files{end + 1} = [tempname() '.csv'];
      write_log(files{end}, varargin{k});
      words{end + 1} = files{end};
    else
      words{end + 1} = word_of(varargin{k});
    end
  end
  if with_json
    files{end + 1} = [tempname() '.json'];
    words = [words, {'--json', files{end}}];
  end
  remove = onCleanup(@() delete_files(files));
  program = getenv('SLIPSTACK');
  if isempty(program)
    program = 'slipstack';
  end
  line = strjoin(cellfun(@quoted, [{program}, words], 'UniformOutput', false), ' ');
  [status, text] = system([line ' 2>&1']);
  if status == 2
    error('slipstack:input', '%s', strtrim(text));
  elseif status ~= 0
    error('slipstack:fault', 'status %d of %s: %s', status, line, strtrim(text));
  end
  result = struct();
  if with_json
    result = jsondecode(fileread(files{end}));
  end
  result.text = text;
end

function yes = gives_json(words)
  alone = {'compare', 'fit', 'diagnose', 'add', 'simulate', 'loop', 'commission', 'bode', 'tune'};
  yes = any(strcmp(words{1}, alone)) || ...
        (strcmp(words{1}, 'experiment') && numel(words) > 1 && ~strcmp(words{2}, 'setup'));
end

function word = word_of(value)
  if ischar(value)
    word = value;
  elseif isnumeric(value) && isscalar(value) && isreal(value)
    word = sprintf('%.17g', value);
  elseif isnumeric(value) && isreal(value) && ~isempty(value)
    word = strjoin(arrayfun(@(x) sprintf('%.17g', x), value(:)', 'UniformOutput', false), ',');
  elseif iscellstr(value)
    word = strjoin(value(:)', ',');
  else
    error('slipstack:input', 'slipstack: an argument is neither text nor number, list of texts, or struct of a log');
  end
end

function word = quoted(word)
  % One word of a shell, whatever is in it.
  if ispc()
    word = ['"' strrep(word, '"', '\"') '"'];
  else
    word = ['''' strrep(word, '''', '''\''''') ''''];
  end
end

function write_log(path, log)
  names = setdiff(fieldnames(log), {'header'}, 'stable');
  if isempty(names)
    error('slipstack:input', 'slipstack: the struct of a log has no columns; name them time_s, position_m, force_N');
  end
  rows = numel(log.(names{1}));
  table = zeros(rows, numel(names));
  for k = 1:numel(names)
    if ~isnumeric(log.(names{k})) || numel(log.(names{k})) ~= rows
      error('slipstack:input', 'slipstack: column %s has %d values, %s has %d; all have as many', names{k}, ...
            numel(log.(names{k})), names{1}, rows);
    end
    table(:, k) = double(log.(names{k})(:));
  end
  file = fopen(path, 'w');
  if file < 0
    error('slipstack:fault', '%s cannot be written', path);
  end
  close = onCleanup(@() fclose(file));
  if isfield(log, 'header')
    keys = fieldnames(log.header);
    for k = 1:numel(keys)
      fprintf(file, '# %s: %s\n', keys{k}, word_of(log.header.(keys{k})));
    end
  end
  fprintf(file, '%s\n', strjoin(names', ','));
  format = [strjoin(repmat({'%.17g'}, 1, numel(names)), ',') '\n'];
  fprintf(file, format, table');
end

function delete_files(files)
  for k = 1:numel(files)
    if exist(files{k}, 'file')
      delete(files{k});
    end
  end
end
