!> gracecg design: plans the manoeuvre. Searches the best one, or judges a given one, at a place of the
!> orbit or along revolutions. With --whisper: weak tones of the rods all the time, in place of a manoeuvre.
module gracecg_cli_design
    use gracecg_base_constants, only: MICROMETRE
    use gracecg_base_version, only: file_comments
    use gracecg_spacecraft_rod_leakage, only: USUAL_ROD_GAIN
    use gracecg_spacecraft_torque_rods, only: take_manoeuvre, WAVEFORM_NAMES
    use gracecg_files_file, only: directory_exists, output_file_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_simulator, only: simulator_t, new_simulator
    use gracecg_planning_calibration, only: write_calibration
    use gracecg_planning_candidates, only: design_settings_t, pattern_567, usual_amplitude, usual_shares
    use gracecg_planning_design, only: manoeuvre_design_t, judge_manoeuvre
    use gracecg_planning_leakage, only: leakage_pair_t, find_pair
    use gracecg_planning_scan, only: map_point_t, map_manoeuvre
    use gracecg_planning_planner, only: plan_request_t, ANYWHERE, EVERYWHERE, plan_t, prepare_plan, find_manoeuvre, &
        times_along, planned_calibration, SHORTEST_ARC, LONGEST_ARC
    use gracecg_planning_nominal_orbit, only: MOST_REVOLUTIONS
    use gracecg_planning_whisper, only: whisper_limits_t, whisper_plan_t, plan_whisper, TIMES
    use gracecg_cli_calibration_argument, only: take_calibration
    use gracecg_cli_console, only: quoted_word
    use gracecg_cli_plan_results, only: rods_table, add_leakage
    use gracecg_cli_work
    implicit none
    private
    public :: declare_design, run_design

    type(design_settings_t), parameter :: USUAL = design_settings_t()

    !> What is asked for.
    type :: request_t
        type(plan_request_t) :: plan
        integer :: map_step = 60            !! s
        character(:), allocatable :: out, map
    end type request_t

    real(dp), parameter :: NANOMETRE = 1e-9_dp
    character(13), parameter :: OF_A_MANOEUVRE(12) = [character(13) :: '--manoeuvre', '--at', '--anywhere', '--everywhere', &
        '--duration', '--rods', '--waveforms', '--taper', '--rise-time', '--rate-limit', '--revolutions', '--map']

contains

    !> Says what the command takes.
    subroutine declare_design(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('design', '[CASE]', 0, 1, &
                                'Plans the manoeuvre of the torque rods for the orbit, satellite and '// &
                                'instruments of a case (default front-1): searches frequencies, phases and '// &
                                'waveforms for the least standard deviation of the worst axis, within the '// &
                                'limits of rods, rate and pointing, and writes the case with the best '// &
                                'manoeuvre as a file that every command takes. The standard deviation is '// &
                                'the theoretical limit under the accelerometer''s noise; the search adds '// &
                                'the errors by the density wave and by curved drag and radiation. With '// &
                                '--manoeuvre a given one is judged instead.', &
                                'gracecg design front-1 --at 1400 --out best.nml'//new_line('a')// &
                                'gracecg design front-2 --waveforms sine --map map.csv'//new_line('a')// &
                                'gracecg design --manoeuvre front-1 --revolutions 15 --map day.csv')
        call add_study_options(arguments, '--cases')
        call arguments%add_option('--manoeuvre', 'CASE', 'judge the manoeuvre of this case, do not search; '// &
                                  'without CASE on the orbit of this case')
        call arguments%add_option('--at', 'S', 'start of the calibration, seconds from the epoch', default='0')
        call arguments%add_option('--anywhere', '', 'choose the start along the revolutions, too')
        call arguments%add_option('--everywhere', '', 'one manoeuvre for the worst axis along all revolutions')
        call arguments%add_option('--duration', 'S', 'of the arc (default: that of the case, 60)')
        call arguments%add_option('--rods', 'AXES', 'rods that may be driven: x, y, z or several of them', default='xyz')
        call arguments%add_option('--amplitude', 'M', 'of each rod, A m^2 (of the strongest torquer, N m), up to '// &
                                  'largest_moment of the case''s &rods (default: as the case drives its rods)')
        call arguments%add_option('--frequencies', 'LOW HIGH', 'Hz, allowed', default=real_text(USUAL%lowest_frequency)//' '// &
                                  real_text(USUAL%highest_frequency))
        call arguments%add_option('--waveforms', 'LIST', 'allowed: of sine, cosine, tapered, square', choices=WAVEFORM_NAMES, &
                                  default='sine,tapered,square')
        call arguments%add_option('--taper', 'S', 'of the smooth start and stop of tapered', default=real_text(USUAL%taper))
        call arguments%add_option('--rise-time', 'S', 'of the edges of square', default=real_text(USUAL%rise_time))
        call arguments%add_option('--rate-limit', 'DEG_S', 'angular velocity about any axis (default: of the '// &
                                  'case, 0.1)')
        call arguments%add_option('--pointing-limit', 'DEG', 'turn away from the nominal attitude (default: of '// &
                                  'the case, 1)')
        call arguments%add_option('--revolutions', 'N', 'of the map, and of --anywhere and --everywhere; 15 are a day', &
                                  default='1')
        call arguments%add_option('--step', 'S', 'whole seconds from place to place of the map', default='60')
        call arguments%add_option('--out', 'FILE', 'the case with the best manoeuvre')
        call arguments%add_option('--map', 'FILE', 'CSV file of the manoeuvre at all places')
        call declare_whisper(arguments)
        call add_study_options(arguments, '--threads --format --options')
    end subroutine declare_design

    !> Searches or judges a manoeuvre, prints and writes it.
    subroutine run_design(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(request_t) :: request
        type(calibration_t) :: calibration
        type(plan_t) :: plan
        type(map_point_t), allocatable :: points(:)     ! the place of the manoeuvre, then those of the map
        type(leakage_pair_t) :: pair
        type(results_t) :: results
        real(dp), allocatable :: times(:)

        if (arguments%has('--whisper')) then
            call run_whisper(arguments, console, misuse, error)
            return
        end if
        call read_request(arguments, request, misuse)
        call take_cases(arguments, calibration, console, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        if (.not. arguments%has('--amplitude')) &
            request%plan%settings%amplitude = usual_amplitude(calibration%case%satellite%rods)
        request%plan%settings%share = usual_shares(calibration%case%satellite%rods)
        call check_writable(request%map, error)
        if (allocated(error)) return

        call tell(console, 'orbit of '//trim(calibration%case%name))
        call prepare_plan(calibration, request%plan, plan, error, console)
        if (.not. allocated(error)) call find_manoeuvre(request%plan, plan, error, console)
        if (allocated(error)) return
        call tell(console, 'map')
        times = [plan%time]
        if (request%map /= '' .or. request%plan%place == EVERYWHERE) &
            times = [times, times_along(plan%orbit, real(request%map_step, dp))]
        call map_manoeuvre(plan%arc, plan%orbit, times, plan%design%rods, request%plan%settings%threads, points, error, console)
        if (allocated(error)) return
        call results%open('design')
        call add_plan(request, plan, points(1), console, results)
        if (request%plan%place /= EVERYWHERE .and. .not. plan%arc%knowledge%rods%direct) then
            ! a second flight, half a revolution away; torquers leak nothing that turns with the field
            call find_pair(plan%arc, plan%orbit, plan%sites(1), plan%design%rods, pair, error)
            if (allocated(error)) return
            call add_leakage(pair, plan%calibration%case, console, results)
        end if
        call add_map(request, plan, points(2:), console, results, error)
        if (.not. allocated(error)) &
            call results%publish(quality_table(points(:1), plan%calibration%case, [trim(plan%calibration%case%name)]), console, &
                                 error)
        if (.not. allocated(error) .and. request%out /= '') call write_case(request, plan, console, error)
    end subroutine run_design

    !> What is asked for; fails for options that contradict each other.
    subroutine read_request(arguments, request, misuse)
        type(arguments_t), intent(in) :: arguments
        type(request_t), intent(out) :: request
        type(error_t), allocatable, intent(out) :: misuse

        character(13), parameter :: OF_THE_SEARCH(8) = [character(13) :: '--anywhere', '--everywhere', '--rods', &
            '--amplitude', '--frequencies', '--waveforms', '--taper', '--rise-time']
        real(dp) :: frequencies(2)
        character(:), allocatable :: rods
        type(string_t), allocatable :: waveforms(:)
        integer :: i

        request%plan%search = .not. arguments%has('--manoeuvre')
        if (arguments%has('--anywhere')) request%plan%place = ANYWHERE
        if (arguments%has('--everywhere')) request%plan%place = EVERYWHERE
        call arguments%get('--at', request%plan%time, misuse, low=0.0_dp, unit='s')
        associate (settings => request%plan%settings)
            call arguments%get('--amplitude', settings%amplitude, misuse, low=0.0_dp, high=1e4_dp, unit='A m^2')
            call arguments%get('--frequencies', frequencies, misuse, low=0.0_dp, high=1e3_dp, unit='Hz')
            settings%lowest_frequency = frequencies(1)
            settings%highest_frequency = frequencies(2)
            call arguments%get('--taper', settings%taper, misuse, low=0.0_dp, unit='s')
            call arguments%get('--rise-time', settings%rise_time, misuse, low=0.0_dp, unit='s')
            call arguments%get_threads(settings%threads, misuse)
            call arguments%get('--waveforms', waveforms, misuse)
            settings%waveform_used = [(any(padded(waveforms) == WAVEFORM_NAMES(i)), i=1, size(WAVEFORM_NAMES))]
            call arguments%get('--rods', rods, misuse)
            settings%rod_used = [(index(rods, AXES(i)) > 0, i=1, 3)]
            call refuse_if(verify(rods, 'xyz,') > 0 .or. .not. any(settings%rod_used), &
                           'option --rods: "'//rods//'" has to be one or several of x, y, z', misuse)
        end associate
        call arguments%get('--revolutions', request%plan%revolutions, misuse, low=1, high=MOST_REVOLUTIONS)
        call arguments%get('--step', request%map_step, misuse, low=1, high=3600)
        call arguments%get('--out', request%out, misuse)
        call arguments%get('--map', request%map, misuse)
        call refuse_if(arguments%has('--anywhere') .and. (arguments%has('--at') .or. arguments%has('--everywhere')), &
                       'options --at, --anywhere and --everywhere: --anywhere chooses the place itself', misuse)
        do i = 1, size(OF_THE_SEARCH)
            call refuse_if(arguments%has('--manoeuvre') .and. arguments%has(trim(OF_THE_SEARCH(i))), 'option '// &
                           trim(OF_THE_SEARCH(i))//' is for the search, and --manoeuvre does not search', misuse)
        end do
    end subroutine read_request

    !> The case whose orbit it is, with the manoeuvre to judge when one is given.
    subroutine take_cases(arguments, calibration, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(calibration_t), intent(out) :: calibration
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(inout) :: misuse
        type(error_t), allocatable, intent(out) :: error

        type(calibration_t) :: of_manoeuvre
        type(study_t) :: study
        character(:), allocatable :: name, manoeuvre
        real(dp) :: rate, pointing

        call arguments%get('--manoeuvre', manoeuvre, misuse)
        name = 'front-1'
        if (manoeuvre /= '') name = manoeuvre
        call take_study(arguments, name, console, study, misuse, error, may_rest=.true.)
        if (allocated(misuse) .or. allocated(error)) return
        calibration = study%calibrations(1)
        if (manoeuvre /= '') then
            call take_calibration(arguments, manoeuvre, of_manoeuvre, error)
            if (allocated(error)) return
            call take_manoeuvre(of_manoeuvre%case%satellite%rods, calibration%case%satellite%rods)
            calibration%case%duration = of_manoeuvre%case%duration
        end if
        associate (case => calibration%case)
            call arguments%get('--duration', case%duration, misuse, low=SHORTEST_ARC, high=LONGEST_ARC, unit='s')
            rate = 0
            pointing = 0
            call arguments%get('--rate-limit', rate, misuse, low=1e-6_dp, high=1e3_dp, unit='deg/s')
            call arguments%get('--pointing-limit', pointing, misuse, low=1e-6_dp, high=180.0_dp, unit='deg')
            if (allocated(misuse)) return
            if (rate > 0) case%limits%rate = rate*DEGREE
            if (pointing > 0) case%limits%pointing = pointing*DEGREE
        end associate
    end subroutine take_cases

    !> The manoeuvre at its place, its errors and its motion.
    subroutine add_plan(request, plan, place, console, results)
        type(request_t), intent(in) :: request
        type(plan_t), intent(in) :: plan
        type(map_point_t), intent(in) :: place
        type(console_t), intent(inout) :: console
        type(results_t), intent(inout) :: results

        type(manoeuvre_design_t) :: other
        type(data_table_t) :: rods
        character(160) :: row

        rods = rods_table(plan%design%rods)
        associate (case => plan%calibration%case, design => plan%design, arc => plan%arc%knowledge)
            write (row, '(a, f4.1, a, f5.1, a)') trim(case%satellite%name)//' satellite, '//time_of(case, place)//' UTC, '// &
                integer_text(nint(place%time))//' s after the epoch (', abs(place%latitude)/DEGREE, &
                merge(' N, ', ' S, ', place%latitude >= 0), abs(place%longitude)/DEGREE, &
                merge(' E)', ' W)', place%longitude >= 0)//', an arc of '//real_text(arc%duration)//' s'
            call console%paragraph(row)
            call console%line('')
            call console%table(rods)
            call console%line('')
            call console%line('errors of the CG offset, mm, body axes')
            if (request%plan%place == EVERYWHERE) then
                call show_quality('worst of '//integer_text(size(plan%sites))//' places', design, console)
            else
                call show_quality('this manoeuvre', design, console)
            end if
            if (request%plan%search) then
                call judge_manoeuvre(plan%arc, plan%sites, pattern_567(request%plan%settings, arc%duration), size(plan%sites), &
                                     other)
                call show_quality('5, 6, 7 cycles, for comparison', other, console)
            end if
            call console%line('')
            write (row, '(a, f7.4, a, f7.4, a, f8.4, a, f7.4, a)') 'greatest angular velocity', design%rate/DEGREE, &
                ' deg/s (limit', arc%limits%rate/DEGREE, '); turn away from the attitude', design%excursion/DEGREE, &
                ' deg (limit', arc%limits%pointing/DEGREE, ')'
            call console%paragraph(row)
            if (request%plan%search) &
                call console%line(integer_text(design%evaluations)//' evaluations of a manoeuvre at a place')
            call results%member('case', trim(case%name))
            call results%member('satellite', trim(case%satellite%name))
            call results%member('epoch_utc', utc_text(case%epoch))
            call results%member('duration_s', arc%duration)
            call results%member('evaluations', design%evaluations)
            call results%begin('limits')
            call results%member('rate_deg_s', arc%limits%rate/DEGREE)
            call results%member('pointing_deg', arc%limits%pointing/DEGREE)
            call results%end()
            call rods%to_json(results, 'rods', units=.false.)
        end associate
    end subroutine add_plan

    subroutine show_quality(label, design, console)
        character(*), intent(in) :: label
        type(manoeuvre_design_t), intent(in) :: design
        type(console_t), intent(inout) :: console

        type(data_table_t) :: table

        if (.not. design%worst < huge(1.0_dp)) then
            call console%line(label//': leaves a direction of the offset unseen')
            return
        end if
        call table%column('kind', 'a', label)
        call axis_columns(table, '', '_mm', 'f10.5', '')
        call table%add('limit: sigma by the noise of the accelerometer', design%sigma/MILLIMETRE)
        call table%add('error by the density wave', design%wave/MILLIMETRE)
        call table%add('error by curved drag and radiation', design%force/MILLIMETRE)
        call table%add('all together, worst axis', [design%worst/MILLIMETRE])
        call table%add_nothing(2)
        call console%table(table)
    end subroutine show_quality

    !> The manoeuvre along the orbit, also as a file.
    subroutine add_map(request, plan, points, console, results, error)
        type(request_t), intent(in) :: request
        type(plan_t), intent(in) :: plan
        type(map_point_t), intent(in) :: points(:)
        type(console_t), intent(inout) :: console
        type(results_t), intent(inout) :: results
        type(error_t), allocatable, intent(out) :: error

        type(data_table_t) :: map
        real(dp) :: greatest(size(points))
        integer :: i

        associate (case => plan%calibration%case)
            map = quality_table(points, case)
            call map%to_json(results, 'map')
            if (size(points) == 0) return
            greatest = [(maxval(points(i)%quality%sigma), i=1, size(points))]
            call console%line('')
            call console%line('map: '//integer_text(size(points))//' places of '//integer_text(plan%orbit%revolutions)// &
                              trim(merge(' revolution ', ' revolutions', plan%orbit%revolutions == 1)))
            call console%table(quality_table(points([minloc(greatest, 1), maxloc(greatest, 1)]), case, &
                                             [character(11) :: 'best place', 'worst place']))
            if (request%map /= '') &
                call map%write(request%map, [file_comments('design', trim(case%satellite%name)//' satellite, orbit of case '// &
                                                           trim(case%name)//' from '//utc_text(case%epoch)// &
                                                           ', a calibration of '//real_text(case%duration)//' s at every place'), &
                                             [character(200) :: 'sigma: theoretical limit; wave, force: errors by the density '// &
                                              'wave and by curved drag and radiation; body axes']], error)
        end associate
    end subroutine add_map

    !> The time of a place in UTC.
    function time_of(case, point) result(text)
        type(case_t), intent(in) :: case            !! From whose epoch the time counts
        type(map_point_t), intent(in) :: point
        character(:), allocatable :: text

        text = utc_text(utc_plus(case%epoch, point%time))
    end function time_of

    !> The manoeuvre at its places, a row each.
    function quality_table(points, case, labels) result(table)
        type(map_point_t), intent(in) :: points(:)
        type(case_t), intent(in) :: case            !! From whose epoch the times count
        character(*), intent(in), optional :: labels(:)     !! Of the places, in a column before the others
        type(data_table_t) :: table

        integer :: i

        if (present(labels)) call table%column('case', 'a', '')
        call table%column('time_s', 'i8', 'time, s')
        call table%column('utc', 'a', 'UTC')
        call table%column('latitude_deg', 'f8.1', 'lat.')
        call table%column('longitude_deg', 'f8.1', 'long.')
        call axis_columns(table, 'sigma_', '_mm', 'f9.5', 'sigma, mm')
        call table%column('worst_sigma_mm', 'f9.5', 'greatest')
        call table%columns_of('worst_x,worst_y,worst_z,wave_x_mm,wave_y_mm,wave_z_mm,force_x_mm,force_y_mm,force_z_mm,'// &
                              'rate_deg_s,pointing_deg')
        do i = 1, size(points)
            associate (point => points(i), quality => points(i)%quality)
                if (present(labels)) call table%add(labels(i))
                call table%add(point%time)
                call table%add(time_of(case, point), [[point%latitude, point%longitude]/DEGREE, &
                                [quality%sigma, point%worst_sigma]/MILLIMETRE, point%worst_direction, &
                                [quality%wave, quality%force]/MILLIMETRE, &
                                [quality%motion%rate, quality%motion%excursion]/DEGREE])
            end associate
        end do
    end function quality_table

    !> The case with the manoeuvre, at its place, and what to do next, if the true motion keeps the limits, too.
    subroutine write_case(request, plan, console, error)
        type(request_t), intent(in) :: request
        type(plan_t), intent(in) :: plan
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(calibration_t) :: planned
        type(simulator_t) :: simulator
        type(error_t), allocatable :: failure
        integer :: run

        planned = planned_calibration(request%plan, plan)
        call write_calibration(request%out, planned, error)
        if (allocated(error)) return
        call new_simulator(planned%case, simulator, failure)
        if (allocated(failure)) then
            call console%warn(request%out//' cannot be simulated as it stands: '//failure%message)
            return
        end if
        call console%line('')
        if (request%plan%search) &
            call console%paragraph(request%out//' has `optimal` estimate scale factors and magnetometer bias, too: '// &
                                   'else they would be the largest errors')
        run = 1
        do while (directory_exists('run'//integer_text(run)))       ! nobody's observations are replaced
            run = run + 1
        end do
        call console%line('next: gracecg simulate '//quoted_word(request%out)//' --out run'//integer_text(run))
    end subroutine write_case

    !> Options of the tones alone.
    subroutine declare_whisper(arguments)
        type(arguments_t), intent(inout) :: arguments

        type(whisper_limits_t) :: usual

        call arguments%add_option('--whisper', '', 'no manoeuvre, but weak tones on all rods all the time, within --amplitude '// &
                                  '(default '//real_text(usual%moment)//' A m^2), --frequencies (default '// &
                                  real_text(usual%band(1))//' '//real_text(usual%band(2))//' Hz), --pointing-limit and '// &
                                  '--range-limit: sigma after a revolution, a day, a week; --out: how to simulate it')
        call arguments%add_option('--range-limit', 'NM', 'of --whisper: largest error of the range by the turns, through '// &
                                  trim(rounded_text(usual%tilt_coupling/MICROMETRE, 3))//' um/rad', &
                                  default=real_text(usual%range/NANOMETRE))
    end subroutine declare_whisper

    !> Finds the tones and says what they reach.
    subroutine run_whisper(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(inout) :: misuse
        type(error_t), allocatable, intent(out) :: error

        type(study_t) :: study
        type(whisper_limits_t) :: limits
        type(whisper_plan_t) :: plan
        type(results_t) :: results
        type(data_table_t) :: reached
        character(:), allocatable :: name
        integer :: i

        do i = 1, size(OF_A_MANOEUVRE)
            call refuse_if(arguments%has(trim(OF_A_MANOEUVRE(i))), 'option '//trim(OF_A_MANOEUVRE(i))//' is of a manoeuvre, '// &
                           'and --whisper has none', misuse)
        end do
        call arguments%get('--amplitude', limits%moment, misuse, low=1e-6_dp, high=1e4_dp, unit='A m^2')
        if (arguments%has('--frequencies')) call arguments%get('--frequencies', limits%band, misuse, low=1e-6_dp, &
                                                               high=1e3_dp, unit='Hz')
        if (arguments%has('--pointing-limit')) then
            call arguments%get('--pointing-limit', limits%turn, misuse, low=1e-9_dp, high=180.0_dp, unit='deg')
            limits%turn = limits%turn*DEGREE
        end if
        call arguments%get('--range-limit', limits%range, misuse, low=1e-9_dp, high=1e9_dp, unit='nm')
        limits%range = limits%range*NANOMETRE
        call take_study(arguments, 'front-1', console, study, misuse, error, may_rest=.true.)
        if (allocated(misuse) .or. allocated(error)) return
        name = 'front-1'
        if (arguments%positional_count() > 0) name = arguments%positional(1)
        associate (case => study%calibrations(1)%case)
            if (.not. arguments%has('--amplitude')) limits%moment = min(limits%moment, case%satellite%rods%largest_moment)
            call plan_whisper(case, limits, plan, error)
            if (allocated(error)) return
            call results%open('design')
            call results%member('case', trim(case%name))
            call show_whisper(plan, limits, console, results, reached)
            call results%publish(reached, console, error)
            if (.not. allocated(error) .and. study%path /= '') call write_whisper(study%path, name, plan, console, error)
        end associate
    end subroutine run_whisper

    !> The tones, what they do, and what they reach.
    subroutine show_whisper(plan, limits, console, results, reached)
        type(whisper_plan_t), intent(in) :: plan
        type(whisper_limits_t), intent(in) :: limits
        type(console_t), intent(inout) :: console
        type(results_t), intent(inout) :: results
        type(data_table_t), intent(out) :: reached

        type(data_table_t) :: tones
        integer :: k

        call tones%column('rod', 'a', 'rod')
        call tones%column('frequency_hz', 'f8.4', 'frequency, Hz')
        call tones%column('moment_a_m2', 'f8.4', 'moment, A m^2')
        call tones%column('current_ma', 'f8.3', 'current, mA')
        call tones%column('turn_urad', 'f8.3', 'turns up to, urad')
        do k = 1, 3
            call tones%add(AXES(k), [plan%tones(k)%frequency, plan%tones(k)%moment, plan%tones(k)%moment/USUAL_ROD_GAIN, &
                                     maxval(plan%tones(k)%turn)*1e6_dp])
        end do
        call console%table(tones)
        call tones%to_json(results, 'tones', units=.false.)
        call console%line('')
        call reached%column('after', 'a', 'after a')
        call axis_columns(reached, 'sigma_', '_mm', 'f9.5', 'sigma, mm')
        call axis_columns(reached, 'noise_alone_', '_mm', 'f9.5', 'by the noise alone, mm')
        do k = 1, size(TIMES)
            call reached%add(TIMES(k), [plan%sigma(:, k), plan%sigma_alone(:, k)]/MILLIMETRE)
        end do
        call console%table(reached)
        call console%line('')
        call console%paragraph('sigma: with leakage of the rods and the push of the air estimated; gains of the rods and '// &
                               'scale of the accelerometer count as known (an error of the scale is the same part of d). '// &
                               'All tones turn the satellite by at most '//trim(rounded_text(plan%turn*1e6_dp, 3))// &
                               ' urad, the range by '//trim(rounded_text(plan%range/NANOMETRE, 3))//' nm (limits '// &
                               trim(rounded_text(limits%turn*1e6_dp, 3))//' urad, '// &
                               trim(rounded_text(limits%range/NANOMETRE, 3))//' nm)')
        call results%member('turn_rad', plan%turn)
        call results%member('range_m', plan%range)
    end subroutine show_whisper

    !> A day of these tones as settings of `level1 simulate`.
    subroutine write_whisper(path, name, plan, console, error)
        character(*), intent(in) :: path, name      !! Of the file; of the case, or its file
        type(whisper_plan_t), intent(in) :: plan
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file

        call file%open(path, error)
        if (allocated(error)) return
        call file%line('&level1_simulation   ! by gracecg design '//name//' --whisper')
        call file%line('    spans = 0, duration = 86400, rod_control = .true., control_hz = 8e-4, science_ma = 0,')
        call file%line('    firing_interval = 60, 228')
        call file%line('    whisper_ma = '//list_of(plan%tones%moment/USUAL_ROD_GAIN))
        call file%line('    whisper_hz = '//list_of(plan%tones%frequency))
        call file%line('/')
        call file%commit(error)
        if (allocated(error)) return
        call console%line('')
        call console%line('next: gracecg level1 simulate '//quoted_word(name)//' --level1 '//quoted_word(path)//' --out day; '// &
                          'gracecg level1 estimate day --setup day/setup.nml --every 5640')
    end subroutine write_whisper

    !> Three numbers of a namelist.
    function list_of(numbers) result(text)
        real(dp), intent(in) :: numbers(3)
        character(:), allocatable :: text

        text = real_text(numbers(1))//', '//real_text(numbers(2))//', '//real_text(numbers(3))
    end function list_of
end module gracecg_cli_design
