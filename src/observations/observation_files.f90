!> An observation set as a folder of files: accelerometer.csv, star_camera.csv, magnetometer.csv,
!> orbit.csv, rods.csv or torque.csv, and setup.nml with what the operator knows. A series without samples has no file;
!> the orbit may be missing, and with an orbit or torquers the magnetometer. Measured moments of the rods, and the history of
!> torquers, where there are any, stand in for the waveforms of the setup.
module gracecg_observations_observation_files
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_text, only: join, real_text, integer_text
    use gracecg_files_file, only: directory_exists, file_exists, make_directory, remove_file
    use gracecg_files_csv, only: csv_writer_t
    use gracecg_files_table, only: table_file_t, read_csv
    use gracecg_files_settings, only: settings_t
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series, has_moments, median_spacing, &
        FEWEST_MOMENTS
    use gracecg_spacecraft_settings, only: TORQUE_COLUMNS
    use gracecg_spacecraft_torque_rods, only: take_measured_moments
    use gracecg_spacecraft_mass_properties, only: mass_properties_t, validate_mass_properties
    use gracecg_observations_knowledge, only: operator_knowledge_t, describe_satellite, &
        describe_instruments, describe_a_priori, ESTIMATION_GROUPS, HEADS
    use gracecg_observations_observation_set, only: observation_set_t, check_observations, has_orbit, &
        SAMPLE_TOLERANCE
    implicit none
    private
    public :: write_observations, observation_writer_t, read_observations, OBSERVATION_FILES, SETUP_FILE
    public :: read_setup, setup_from_text, setup_text

    integer, parameter :: ACCELEROMETER = 1, STAR_CAMERA = 2, MAGNETOMETER = 3, ORBIT = 4, RODS = 5, TORQUE = 6, FURTHER = 7
    integer, parameter :: MAY_BE_LOST = 10  !! Of the accelerometer, rows at the beginning: a second of a minute does not matter
    !> What an operator knows
    integer, parameter :: TABLE_COUNT = 7, SETUP_FILE = 8
    !> The files of an observation set, in its folder
    character(26), parameter :: OBSERVATION_FILES(8) = [character(26) :: &
        'accelerometer.csv', 'star_camera.csv', 'magnetometer.csv', 'orbit.csv', 'rods.csv', 'torque.csv', &
        'further_accelerometers.csv', 'setup.nml']

    character(8), parameter :: ACCELEROMETER_COLUMNS(4) = &
        [character(8) :: 'time_s', 'ax_m_s2', 'ay_m_s2', 'az_m_s2']
    character(13), parameter :: FURTHER_COLUMNS(5) = &
        [character(13) :: 'time_s', 'accelerometer', 'ax_m_s2', 'ay_m_s2', 'az_m_s2']
    character(8), parameter :: STAR_CAMERA_COLUMNS(6) = &
        [character(8) :: 'time_s', 'camera', 'q1', 'q2', 'q3', 'q4']
    character(8), parameter :: MAGNETOMETER_COLUMNS(4) = &
        [character(8) :: 'time_s', 'bx_tesla', 'by_tesla', 'bz_tesla']
    character(8), parameter :: ORBIT_COLUMNS(4) = &
        [character(8) :: 'time_s', 'rx_m', 'ry_m', 'rz_m']
    character(8), parameter :: RODS_COLUMNS(4) = &
        [character(8) :: 'time_s', 'mx_a_m2', 'my_a_m2', 'mz_a_m2']

    !> The files of an observation set on their way: rows are written as they come, and the files stand under their
    !> names after `commit`.
    type :: observation_writer_t
        integer :: rows(TABLE_COUNT) = 0        !! So far, of each of OBSERVATION_FILES
        type(csv_writer_t), pointer, private :: tables(:) => null()
        ! until `discard`; not a fixed array, which gfortran 12 finalises at wrong addresses
        character(:), allocatable, private :: folder
    contains
        procedure :: open => open_tables        !! Begins the files in a folder, which is made if it is not there
        procedure :: append => append_rows      !! Writes the samples of a set, which follow those before
        procedure :: commit => commit_all       !! Ends the files and gives them their names
        procedure :: discard => discard_all     !! Leaves nothing behind
    end type observation_writer_t

    !> The rows of a file, and where they stand in it.
    type :: series_t
        type(table_file_t) :: file
        real(dp), allocatable :: table(:, :)    !! (row, column)
    end type series_t

contains

    !> Writes an observation set into a folder, which is made if it is not there. After a failure
    !> (the folder cannot be made, the disk is full, a value is not finite) none of the files stands,
    !> or those of before still do.
    subroutine write_observations(folder, observations, comments, error)
        character(*), intent(in) :: folder          !! Is made if it is not there
        type(observation_set_t), intent(in) :: observations
        character(*), intent(in) :: comments(:)     !! First lines of every file; may be none
        type(error_t), allocatable, intent(out) :: error

        type(observation_writer_t) :: writer

        if (.not. allocated(observations%accelerometer_time)) then
            call fail(error, folder//': not written: the observation set is empty')
            return
        end if
        call writer%open(folder, error)
        if (.not. allocated(error)) then
            call writer%append(observations)
            call writer%commit(observations%knowledge, comments, error)
        end if
        call writer%discard()
    end subroutine write_observations

    !> Begins the files. Fails when the folder cannot be made, or a file not be written.
    subroutine open_tables(self, folder, error)
        class(observation_writer_t), intent(inout) :: self
        character(*), intent(in) :: folder      !! Is made if it is not there
        type(error_t), allocatable, intent(out) :: error

        call make_directory(folder, error)
        if (allocated(error)) return
        self%folder = folder
        self%rows = 0
        call self%discard()
        allocate (self%tables(TABLE_COUNT))
        call open_one(ACCELEROMETER, join(ACCELEROMETER_COLUMNS, ','))
        call open_one(STAR_CAMERA, join(STAR_CAMERA_COLUMNS, ','))
        call open_one(MAGNETOMETER, join(MAGNETOMETER_COLUMNS, ','))
        call open_one(ORBIT, join(ORBIT_COLUMNS, ','))
        call open_one(RODS, join(RODS_COLUMNS, ','))
        call open_one(TORQUE, join(TORQUE_COLUMNS, ','))
        call open_one(FURTHER, join(FURTHER_COLUMNS, ','))

    contains

        subroutine open_one(number, columns)
            integer, intent(in) :: number
            character(*), intent(in) :: columns

            character(1), parameter :: NO_COMMENTS(0) = [character(1) ::]

            if (.not. allocated(error)) &
                call self%tables(number)%open(path_of(folder, number), columns, NO_COMMENTS, error)
        end subroutine open_one
    end subroutine open_tables

    !> Writes the samples of a set behind those before. The knowledge is not looked at.
    subroutine append_rows(self, observations)
        class(observation_writer_t), intent(inout) :: self
        type(observation_set_t), intent(in) :: observations

        integer :: i, k

        do i = 1, size(observations%accelerometer_time)
            call self%tables(ACCELEROMETER)%row([observations%accelerometer_time(i), &
                                                 observations%acceleration(:, i)])
            do k = 2, observations%knowledge%line%number
                call self%tables(FURTHER)%row([observations%accelerometer_time(i), real(k, dp), &
                                               observations%further_acceleration(:, i, k - 1)])
                self%rows(FURTHER) = self%rows(FURTHER) + 1
            end do
        end do
        do i = 1, size(observations%star_camera_time)
            call self%tables(STAR_CAMERA)%row([observations%star_camera_time(i), &
                                               real(observations%star_camera_head(i), dp), &
                                               observations%quaternion(:, i)])
        end do
        do i = 1, size(observations%magnetometer_time)
            call self%tables(MAGNETOMETER)%row([observations%magnetometer_time(i), &
                                                observations%field(:, i)])
        end do
        self%rows(ACCELEROMETER) = self%rows(ACCELEROMETER) + size(observations%accelerometer_time)
        self%rows(STAR_CAMERA) = self%rows(STAR_CAMERA) + size(observations%star_camera_time)
        self%rows(MAGNETOMETER) = self%rows(MAGNETOMETER) + size(observations%magnetometer_time)
        if (.not. has_orbit(observations)) return
        do i = 1, size(observations%orbit_time)
            call self%tables(ORBIT)%row([observations%orbit_time(i), observations%orbit_position(:, i)])
        end do
        self%rows(ORBIT) = self%rows(ORBIT) + size(observations%orbit_time)
    end subroutine append_rows

    !> Gives the files their names, and writes what the operator knows, with measured moments of the rods. When one
    !> fails, those that have theirs are removed again. Of a series without samples no file stands, not even an older
    !> one.
    subroutine commit_all(self, knowledge, comments, error)
        class(observation_writer_t), intent(inout) :: self
        type(operator_knowledge_t), intent(in) :: knowledge
        character(*), intent(in) :: comments(:)     !! First lines of the setup; may be none
        type(error_t), allocatable, intent(out) :: error

        integer :: i, committed

        associate (measured => knowledge%rods%measured, number => file_of_moments(knowledge))
            if (has_moments(measured)) then
                do i = 1, size(measured%time)
                    call self%tables(number)%row([measured%time(i), measured%moment(:, i)])
                end do
                self%rows(number) = size(measured%time)
            end if
        end associate
        committed = 0
        do i = 1, TABLE_COUNT
            if (self%rows(i) > 0) call self%tables(i)%commit(error)
            if (allocated(error)) exit
            committed = i
        end do
        if (.not. allocated(error)) call write_setup(self%folder, knowledge, comments, error)
        do i = 1, committed
            if (allocated(error) .or. self%rows(i) == 0) call remove_file(path_of(self%folder, i))
        end do
    end subroutine commit_all

    !> Gives up what is not committed; after `open`, always. Does nothing where nothing is open.
    subroutine discard_all(self)
        class(observation_writer_t), intent(inout) :: self

        integer :: i

        if (.not. associated(self%tables)) return
        do i = 1, TABLE_COUNT
            call self%tables(i)%discard()
        end do
        deallocate (self%tables)
    end subroutine discard_all

    subroutine write_setup(folder, knowledge, comments, error)
        character(*), intent(in) :: folder, comments(:)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: settings
        type(operator_knowledge_t) :: copy
        integer :: i

        do i = 1, size(comments)
            call settings%comment(trim(comments(i)))
        end do
        copy = knowledge
        call describe_setup(settings, copy)
        call settings%save(path_of(folder, SETUP_FILE), error)
    end subroutine write_setup

    !> All that setup.nml holds.
    subroutine describe_setup(settings, knowledge)
        class(settings_t), intent(inout) :: settings
        type(operator_knowledge_t), intent(inout) :: knowledge

        call describe_satellite(settings, knowledge)
        call describe_instruments(settings, knowledge)
        call describe_a_priori(settings, knowledge%a_priori)
    end subroutine describe_setup

    !> Reads an observation set from its folder.
    !>
    !> Fails, naming file and line, when a file is missing or cuts off in mid-line, a header
    !> differs, a value is not a finite number, times go back or two samples of one time differ, a
    !> camera is none, a quaternion is not of unit length, or the setup is refused; and when a series
    !> does not reach from the beginning to the end of the arc. With an orbit the magnetometer need
    !> not: a model stands in.
    subroutine read_observations(folder, observations, error)
        character(*), intent(in) :: folder  !! Where the files are
        type(observation_set_t), intent(out) :: observations
        type(error_t), allocatable, intent(out) :: error

        if (folder == '') then
            call fail(error, 'the name of the folder is empty')
            return
        else if (.not. directory_exists(folder)) then
            if (file_exists(folder)) then
                call fail(error, trim(folder)//': is a file; name the folder of an observation set')
            else
                call fail(error, trim(folder)//': no such folder; name the folder of an observation set')
            end if
            return
        end if
        call read_setup(path_of(folder, SETUP_FILE), observations%knowledge, error)
        if (.not. allocated(error)) call read_accelerometer(folder, observations, error)
        if (.not. allocated(error)) call read_orbit(folder, observations, error)
        if (.not. allocated(error)) call read_rods(folder, observations%knowledge, error)
        if (.not. allocated(error)) call read_magnetometer(folder, observations, error)
        if (.not. allocated(error)) call read_star_camera(folder, observations, error)
        if (allocated(error)) return
        call check_observations(observations, error)
        call add_context(error, trim(folder))
    end subroutine read_observations

    subroutine read_accelerometer(folder, observations, error)
        character(*), intent(in) :: folder
        type(observation_set_t), intent(inout) :: observations
        type(error_t), allocatable, intent(out) :: error

        associate (knowledge => observations%knowledge)
            call read_vectors(folder, ACCELEROMETER, ACCELEROMETER_COLUMNS, observations%accelerometer_time, &
                              observations%acceleration, error, knowledge%accelerometer_interval, knowledge%duration)
        end associate
        if (.not. allocated(error) .and. observations%knowledge%line%number > 1) call read_further(folder, observations, error)
    end subroutine read_accelerometer

    !> The samples of the accelerometers beyond the first: a row each at every time of accelerometer.csv.
    subroutine read_further(folder, observations, error)
        character(*), intent(in) :: folder
        type(observation_set_t), intent(inout) :: observations
        type(error_t), allocatable, intent(out) :: error

        type(series_t) :: series
        integer :: i, k, row, others, many

        call read_series(path_of(folder, FURTHER), FURTHER_COLUMNS, series, error)
        if (allocated(error)) return
        others = observations%knowledge%line%number - 1
        many = size(observations%accelerometer_time)
        allocate (observations%further_acceleration(3, many, others))
        do row = 1, size(series%table, 1)
            i = min((row - 1)/others + 1, many)
            k = modulo(row - 1, others) + 2
            if (row > many*others .or. any(abs(series%table(row, :2) - [observations%accelerometer_time(i), real(k, dp)]) > 0)) then
                call series%file%fail_at(row, 'columns time_s and accelerometer: after every time of accelerometer.csv a row '// &
                                         'of each of the accelerometers 2 to '//integer_text(others + 1)//' is needed', error)
                return
            end if
            observations%further_acceleration(:, i, k - 1) = series%table(row, 3:5)
        end do
        if (size(series%table, 1) < many*others) &
            call series%file%fail_at(size(series%table, 1), 'the last of '//integer_text(size(series%table, 1))//' rows, but '// &
                                     integer_text(many*others)//' are needed, one of each of the accelerometers 2 to '// &
                                     integer_text(others + 1)//' at every time of accelerometer.csv', error)
    end subroutine read_further

    subroutine read_orbit(folder, observations, error)
        character(*), intent(in) :: folder
        type(observation_set_t), intent(inout) :: observations
        type(error_t), allocatable, intent(out) :: error

        if (file_exists(path_of(folder, ORBIT))) &
            call read_vectors(folder, ORBIT, ORBIT_COLUMNS, observations%orbit_time, observations%orbit_position, error)
    end subroutine read_orbit

    subroutine read_magnetometer(folder, observations, error)
        character(*), intent(in) :: folder
        type(observation_set_t), intent(inout) :: observations
        type(error_t), allocatable, intent(out) :: error

        if (.not. (has_orbit(observations) .or. observations%knowledge%rods%direct)) then
            associate (knowledge => observations%knowledge)
                call read_vectors(folder, MAGNETOMETER, MAGNETOMETER_COLUMNS, observations%magnetometer_time, &
                                  observations%field, error, knowledge%magnetometer_interval, knowledge%duration, &
                                  '. If the magnetometer failed, add '//trim(OBSERVATION_FILES(ORBIT))// &
                                  ': a field model then stands in')
            end associate
        else if (file_exists(path_of(folder, MAGNETOMETER))) then
            call read_vectors(folder, MAGNETOMETER, MAGNETOMETER_COLUMNS, observations%magnetometer_time, &
                              observations%field, error)
        else
            allocate (observations%magnetometer_time(0), observations%field(3, 0))
        end if
    end subroutine read_magnetometer

    !> Times and vectors of a file that, where an interval is given, has to reach over the arc.
    subroutine read_vectors(folder, number, columns, times, vectors, error, interval, duration, remedy)
        character(*), intent(in) :: folder, columns(:)
        integer, intent(in) :: number                           !! Of OBSERVATION_FILES
        real(dp), allocatable, intent(inout) :: times(:), vectors(:, :)
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: interval, duration    !! s
        character(*), intent(in), optional :: remedy            !! Where it does not reach over the arc

        type(series_t) :: series

        call read_series(path_of(folder, number), columns, series, error)
        if (.not. allocated(error)) call check_times(series, error)
        if (allocated(error)) return
        if (present(interval)) &
            call check_coverage(series, interval, duration, error, merge(MAY_BE_LOST, 0, number == ACCELEROMETER))
        if (allocated(error) .and. present(remedy)) error%message = error%message//remedy
        if (allocated(error)) return
        times = series%table(:, 1)
        vectors = transpose(series%table(:, 2:4))
    end subroutine read_vectors

    subroutine read_star_camera(folder, observations, error)
        character(*), intent(in) :: folder
        type(observation_set_t), intent(inout) :: observations
        type(error_t), allocatable, intent(out) :: error

        type(series_t) :: series

        if (observations%knowledge%knows_angular_velocity() .and. .not. file_exists(path_of(folder, STAR_CAMERA))) then
            allocate (observations%star_camera_time(0), observations%star_camera_head(0), observations%quaternion(4, 0))
            return
        end if
        call read_series(path_of(folder, STAR_CAMERA), STAR_CAMERA_COLUMNS, series, error)
        if (.not. allocated(error)) call check_star_camera(series, error)
        if (.not. allocated(error)) call check_times(series, error, nint(series%table(:, 2)))
        if (.not. allocated(error)) &
            call check_coverage(series, observations%knowledge%star_camera_interval, &
                                observations%knowledge%duration, error)
        if (allocated(error)) return
        observations%star_camera_time = series%table(:, 1)
        observations%star_camera_head = nint(series%table(:, 2))
        observations%quaternion = transpose(series%table(:, 3:6))
    end subroutine read_star_camera

    !> Where the moments of rods stand, or the torques of torquers.
    pure integer function file_of_moments(knowledge) result(number)
        type(operator_knowledge_t), intent(in) :: knowledge

        number = merge(TORQUE, RODS, knowledge%rods%direct)
    end function file_of_moments

    !> What was measured of the rods, or the history of torquers, takes the place of the waveforms.
    subroutine read_rods(folder, knowledge, error)
        character(*), intent(in) :: folder
        type(operator_knowledge_t), intent(inout) :: knowledge
        type(error_t), allocatable, intent(out) :: error

        type(series_t) :: series
        type(moment_series_t) :: measured
        integer :: i
        real(dp), allocatable :: rows(:, :)     ! without those that are given twice
        integer :: number

        number = file_of_moments(knowledge)
        if (file_exists(path_of(folder, RODS + TORQUE - number))) then
            call fail(error, path_of(folder, RODS + TORQUE - number)//': stands beside a setup.nml '// &
                      trim(merge('with   ', 'without', knowledge%rods%direct))//' torquers (group &torquers) and would not be '// &
                      'used: correct the setup, or leave the file out')
            return
        end if
        if (.not. file_exists(path_of(folder, number))) return
        if (knowledge%rods%direct) call read_series(path_of(folder, number), TORQUE_COLUMNS, series, error)
        if (.not. knowledge%rods%direct) call read_series(path_of(folder, number), RODS_COLUMNS, series, error)
        if (.not. allocated(error)) call check_times(series, error)
        if (allocated(error)) return
        associate (all_rows => series%table, n => size(series%table, 1))
            rows = all_rows(pack([(i, i=1, n)], [.true., all_rows(2:, 1) > all_rows(:n - 1, 1)]), :)
        end associate
        if (size(rows, 1) >= FEWEST_MOMENTS) &
            call check_coverage(series, median_spacing(rows(:, 1)), knowledge%duration, error)
        if (allocated(error)) return
        call new_moment_series(rows(:, 1), transpose(rows(:, 2:4)), measured, error, direct=knowledge%rods%direct)
        call add_context(error, path_of(folder, number))
        if (.not. allocated(error)) call take_measured_moments(measured, knowledge%rods)
    end subroutine read_rods

    !> Reads a setup.nml. Fails, with file, line and key, for a key that is not known, a value that is
    !> missing or not allowed, and for mass properties that no body has.
    subroutine read_setup(path, knowledge, error)
        character(*), intent(in) :: path    !! Of the file
        type(operator_knowledge_t), intent(out) :: knowledge
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: settings

        call settings%open(path, error)
        if (.not. allocated(error)) call take_setup(settings, path, knowledge, error)
    end subroutine read_setup

    !> A setup from the text of a setup.nml; `name` stands for the file in messages. Fails as
    !> `read_setup`.
    subroutine setup_from_text(text, name, knowledge, error)
        character(*), intent(in) :: text, name  !! Content; what stands for the file in messages
        type(operator_knowledge_t), intent(out) :: knowledge
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: settings

        call settings%open_text(text, name, error)
        if (.not. allocated(error)) call take_setup(settings, name, knowledge, error)
    end subroutine setup_from_text

    subroutine take_setup(settings, name, knowledge, error)
        type(settings_t), intent(inout) :: settings
        character(*), intent(in) :: name
        type(operator_knowledge_t), intent(inout) :: knowledge
        type(error_t), allocatable, intent(out) :: error

        call describe_setup(settings, knowledge)
        call settings%finish(error, others=ESTIMATION_GROUPS)
        if (allocated(error)) return
        call validate_mass_properties(mass_properties_t(knowledge%mass, knowledge%inertia, &
                                                        [0.0_dp, 0.0_dp, 0.0_dp]), error)
        call add_context(error, name)
    end subroutine take_setup

    !> The text of a setup.nml: what `read_setup` reads. Fails when a setting is not finite.
    subroutine setup_text(knowledge, text, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        character(:), allocatable, intent(out) :: text  !! Lines separated by line feeds
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: settings
        type(operator_knowledge_t) :: copy

        copy = knowledge
        call describe_setup(settings, copy)
        call settings%to_text(text, error)
    end subroutine setup_text

    !> Reads a CSV file. A last line without its end tells of a file that was cut off: its last
    !> number may have lost digits.
    subroutine read_series(path, columns, series, error)
        character(*), intent(in) :: path, columns(:)
        type(series_t), intent(out) :: series
        type(error_t), allocatable, intent(out) :: error

        call read_csv(path, columns, series%file, error)
        if (.not. allocated(error)) call series%file%get_numbers(columns, series%table, error)
        if (allocated(error)) return
        associate (file => series%file%text)
            if (file%text(len(file%text):) /= new_line('a')) &
                call file%fail_at(file%line_count(), 'the last line has no line end: the file seems to be '// &
                                  'truncated', error)
        end associate
    end subroutine read_series

    !> Times must increase, of each camera by itself; a row that is given twice, alike, may pass.
    subroutine check_times(series, error, head_of)
        type(series_t), intent(in) :: series
        type(error_t), allocatable, intent(out) :: error
        integer, intent(in), optional :: head_of(:)     !! Of each row

        integer :: previous(HEADS), i, k, head

        previous = 0
        head = 1
        do i = 1, size(series%table, 1)
            if (present(head_of)) head = head_of(i)
            k = previous(head)
            previous(head) = i
            if (k == 0) cycle
            if (series%table(i, 1) > series%table(k, 1)) cycle
            if (all(abs(series%table(i, :) - series%table(k, :)) <= 0)) cycle
            call series%file%fail_at(i, 'column time_s: times must increase, but '//real_text(series%table(i, 1))// &
                                     ' follows '//real_text(series%table(k, 1)), error)
            return
        end do
    end subroutine check_times

    !> Camera numbers and unit quaternions.
    subroutine check_star_camera(series, error)
        type(series_t), intent(in) :: series
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: length
        integer :: i, head

        do i = 1, size(series%table, 1)
            length = norm2(series%table(i, 3:6))
            if (.not. any([(abs(series%table(i, 2) - head) <= 0, head=1, HEADS)])) then
                call series%file%fail_at(i, 'column camera: '//real_text(series%table(i, 2))// &
                                         ' is not the number of a camera head: 1 or '//integer_text(HEADS), error)
            else if (abs(length - 1) > SAMPLE_TOLERANCE) then
                call series%file%fail_at(i, 'columns q1 to q4: not a unit quaternion: its length is '// &
                                         real_text(length)//'; allowed is 1 within '//real_text(SAMPLE_TOLERANCE), error)
            end if
            if (allocated(error)) return
        end do
    end subroutine check_star_camera

    !> A series must begin within its first interval, but for some rows, and end within the last one of the arc: else
    !> the file has lost rows.
    subroutine check_coverage(series, interval, duration, error, may_be_lost)
        type(series_t), intent(in) :: series
        real(dp), intent(in) :: interval, duration      !! s
        type(error_t), allocatable, intent(out) :: error
        integer, intent(in), optional :: may_be_lost    !! Rows at the beginning, without harm

        ! of an interval, for the rounding of time tags
        real(dp), parameter :: SLACK = 0.01_dp
        integer :: last, lost

        lost = 0
        if (present(may_be_lost)) lost = may_be_lost
        last = size(series%table, 1)
        associate (first_time => series%table(1, 1), last_time => series%table(last, 1))
            if (first_time > (1 + lost + SLACK)*interval) then
                call series%file%fail_at(1, 'the first sample, at '//real_text(first_time)// &
                                  ' s, comes too late after the epoch: sampled at '// &
                                  real_text(interval)//' s, rows are missing', error)
            else if (last_time < duration - (1 - SLACK)*interval) then
                call series%file%fail_at(last, 'the last sample, at '//real_text(last_time)// &
                                  ' s, comes too early for the duration of '// &
                                  real_text(duration)// &
                                  ' s in setup.nml: the file seems to be truncated; else give '// &
                                  'the shorter duration', error)
            end if
        end associate
    end subroutine check_coverage

    pure function path_of(folder, number) result(path)
        character(*), intent(in) :: folder
        integer, intent(in) :: number       !! Of OBSERVATION_FILES
        character(len_trim(folder) + 1 + len_trim(OBSERVATION_FILES(number))) :: path

        path = trim(folder)//'/'//trim(OBSERVATION_FILES(number))
    end function path_of
end module gracecg_observations_observation_files
