!> gracecg design: plans the manoeuvre. Searches the best one, or judges a given one, at a place of the
!> orbit or along revolutions.
module gracecg_cli_design
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_progress, only: tell
    use gracecg_files_file, only: check_writable, output_file_t
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: string_t, integer_text, real_text
    use gracecg_environment_time, only: utc_plus, utc_text
    use gracecg_files_data_table, only: data_table_t
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, take_manoeuvre, MAX_DIPOLE, WAVEFORM_NAMES, PATTERN_RULES
    use gracecg_simulation_case, only: case_t
    use gracecg_planning_calibration, only: calibration_t, calibration_text
    use gracecg_planning_leakage, only: leakage_pair_t, find_pair
    use gracecg_planning_map, only: map_point_t, map_manoeuvre
    use gracecg_planning_programme, only: candidate_t, programme_t, candidate_of_point, best_programme, MOST_MANOEUVRES
    use gracecg_cli_leakage, only: show_leakage, put_leakage
    use gracecg_cli_programme, only: show_programme, put_programme
    use gracecg_cli_reliable_manoeuvre, only: show_reliable, put_reliable
    use gracecg_planning_candidates, only: design_settings_t, pattern_567
    use gracecg_planning_design, only: manoeuvre_design_t, judge_manoeuvre
    use gracecg_planning_reliable_design, only: reliable_design_t, make_reliable
    use gracecg_planning_scan, only: rods_at_place
    use gracecg_planning_planner, only: plan_request_t, ANYWHERE, EVERYWHERE, plan_t, prepare_plan, find_manoeuvre, &
        times_along, planned_calibration, SHORTEST_ARC, LONGEST_ARC, MOST_REVOLUTIONS
    use gracecg_cli_calibration_argument, only: add_options_option, add_cases_option, take_one_calibration, &
        take_firing_calibration
    use gracecg_cli_arguments, only: arguments_t, refuse_if
    use gracecg_cli_console, only: console_t, quoted_word
    use gracecg_cli_results, only: results_t, add_format_option, take_format
    implicit none
    private
    public :: declare_design, run_design

    character(5), parameter :: SATELLITES(2) = [character(5) :: 'front', 'back']
    character(*), parameter :: QUALITY_COLUMNS = 'time_s,utc,latitude_deg,longitude_deg,sigma_x_mm,sigma_y_mm,'// &
                               'sigma_z_mm,worst_sigma_mm,worst_x,worst_y,worst_z,wave_x_mm,wave_y_mm,'// &
                               'wave_z_mm,force_x_mm,force_y_mm,force_z_mm,rate_deg_s,pointing_deg'

    !> What is asked for.
    type :: request_t
        type(plan_request_t) :: plan
        integer :: map_step = 60            !! s
        integer :: manoeuvres = 0           !! Of a programme; 0: none is asked for
        real(dp) :: reliable = 0            !! Largest undetected effect wanted, m; 0: whatever it is
        character(:), allocatable :: out, map
    end type request_t

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
                                'gracecg design --satellite front --at 1400 --out best.nml'//new_line('a')// &
                                'gracecg design front-2 --waveforms sine --map map.csv'//new_line('a')// &
                                'gracecg design --manoeuvre front-1 --revolutions 15 --map day.csv')
        call add_cases_option(arguments, 'front-1', single=.true.)
        call arguments%add_option('--satellite', 'NAME', 'front or back: the orbit of its case 1, instead of a CASE', &
                                  choices=SATELLITES)
        call arguments%add_option('--manoeuvre', 'CASE', 'judge the manoeuvre of this case, do not search; '// &
                                  'without --satellite and CASE on the orbit of this case')
        call arguments%add_option('--pattern', 'NAME', 'judge the report''s two rods as a rule of its section 4.2 chooses them '// &
                                  'at the place, do not search: y-z, as in the report, or general', choices=PATTERN_RULES)
        call arguments%add_option('--at', 'S', 'start of the calibration, seconds from the epoch (default 0)')
        call arguments%add_option('--anywhere', '', 'choose the start along the revolutions, too')
        call arguments%add_option('--everywhere', '', 'one manoeuvre for the worst axis along all revolutions')
        call arguments%add_option('--duration', 'S', 'of the arc (default: that of the case, 60)')
        call arguments%add_option('--target-mm', 'MM', 'take the shortest arc, in steps of 6 s up to the '// &
                                  'duration, whose worst axis is at most this')
        call arguments%add_option('--reliable', 'MM', 'change it until no single wrong belief of the operator could move a '// &
                                  'component by more than this without a test seeing it: a slow component for the star '// &
                                  'camera beside the fast one; sigma grows')
        call arguments%add_option('--rods', 'AXES', 'rods that may be driven: x, y, z or several of them '// &
                                  '(default xyz)')
        call arguments%add_option('--amplitude', 'M', 'of each rod, A m^2 (default 30)')
        call arguments%add_option('--frequencies', 'LOW HIGH', 'Hz, allowed (default 0.05 0.2)')
        call arguments%add_option('--waveforms', 'LIST', 'allowed: of sine, cosine, tapered, square (default '// &
                                  'sine,tapered,square)', choices=WAVEFORM_NAMES)
        call arguments%add_option('--taper', 'S', 'of the smooth start and stop of tapered (default 5)')
        call arguments%add_option('--rise-time', 'S', 'of the edges of square (default 1)')
        call arguments%add_option('--rate-limit', 'DEG_S', 'angular velocity about any axis (default: of the '// &
                                  'case, 0.1)')
        call arguments%add_option('--pointing-limit', 'DEG', 'turn away from the nominal attitude (default: of '// &
                                  'the case, 1)')
        call arguments%add_option('--revolutions', 'N', 'of the map, and of --anywhere and --everywhere '// &
                                  '(default 1; 15 are a day)')
        call arguments%add_option('--step', 'S', 'whole seconds from place to place of the map (default 60)')
        call arguments%add_option('--manoeuvres', 'N', 'the best programme of so many flights of the manoeuvre at the places '// &
                                  'of the map, together')
        call arguments%add_option('--out', 'FILE', 'the case with the best manoeuvre')
        call arguments%add_option('--map', 'FILE', 'CSV file of the manoeuvre at all places')
        call add_format_option(arguments)
        call arguments%add_option('--threads', 'N', 'in parallel (default: as many as there are processors)')
        call add_options_option(arguments)
    end subroutine declare_design

    !> Searches or judges a manoeuvre, prints and writes it.
    subroutine run_design(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(request_t) :: request
        type(calibration_t) :: calibration
        type(plan_t) :: plan
        type(map_point_t), allocatable :: points(:)
        type(candidate_t), allocatable :: candidates(:)
        type(programme_t) :: programme
        type(leakage_pair_t), allocatable :: pair
        type(reliable_design_t), allocatable :: reliable
        integer :: i

        call read_request(arguments, request, misuse)
        call take_format(arguments, console, misuse)
        if (.not. allocated(misuse)) call take_cases(arguments, request, calibration, console, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        call check_writable(request%out, error)
        if (.not. allocated(error)) call check_writable(request%map, error)
        if (allocated(error)) return

        call tell(console, 'orbit of '//trim(calibration%case%name))
        call prepare_plan(calibration, request%plan, plan, error, console)
        if (allocated(error)) return
        call find_manoeuvre(request%plan, plan, error, console)
        if (allocated(error)) return
        if (request%reliable > 0) then
            allocate (reliable)
            call make_reliable(request%plan, plan, request%reliable, reliable, error, console)
            if (allocated(error)) return
            plan%design = reliable%design
        end if
        call tell(console, 'map')
        call map_places(request, plan, points, error, console)
        if (allocated(error)) return
        if (request%plan%place /= EVERYWHERE) then
            allocate (pair)
            call find_pair(plan%arc, plan%orbit, plan%sites(1), plan%design%rods, pair, error)
            if (allocated(error)) return
        end if
        call show(request, plan, points, pair, console)
        if (allocated(reliable)) call show_reliable(reliable, console)
        if (request%manoeuvres > 0) then
            allocate (candidates(size(points)))
            do i = 1, size(points)
                candidates(i) = candidate_of_point(points(i), plan%arc%knowledge%duration)
            end do
            call best_programme(candidates, request%manoeuvres, programme)
            call show_programme(candidates, programme, 0.0_dp, console)
        end if
        call publish(plan, points, pair, reliable, candidates, programme, console, error)
        if (.not. allocated(error) .and. request%map /= '') call write_map(request, plan%calibration%case, points(2:), error)
        if (.not. allocated(error) .and. request%out /= '') call write_case(request, plan, error)
    end subroutine run_design

    subroutine read_request(arguments, request, misuse)
        type(arguments_t), intent(in) :: arguments
        type(request_t), intent(out) :: request
        type(error_t), allocatable, intent(out) :: misuse

        type(design_settings_t), parameter :: DEFAULT = design_settings_t()
        real(dp) :: frequencies(2)
        character(:), allocatable :: rods
        type(string_t), allocatable :: waveforms(:)
        integer :: i

        request%plan%search = .not. (arguments%has('--manoeuvre') .or. arguments%has('--pattern'))
        if (arguments%has('--anywhere')) request%plan%place = ANYWHERE
        if (arguments%has('--everywhere')) request%plan%place = EVERYWHERE
        call arguments%get('--at', request%plan%time, misuse, default=0.0_dp, low=0.0_dp, unit='s')
        associate (settings => request%plan%settings)
            call arguments%get('--amplitude', settings%amplitude, misuse, default=DEFAULT%amplitude, &
                               low=0.0_dp, high=MAX_DIPOLE, unit='A m^2')
            call arguments%get('--frequencies', frequencies, misuse, default=[DEFAULT%lowest_frequency, &
                               DEFAULT%highest_frequency], low=0.0_dp, high=1e3_dp, unit='Hz')
            settings%lowest_frequency = frequencies(1)
            settings%highest_frequency = frequencies(2)
            call arguments%get('--taper', settings%taper, misuse, default=DEFAULT%taper, low=0.0_dp, unit='s')
            call arguments%get('--rise-time', settings%rise_time, misuse, default=DEFAULT%rise_time, &
                               low=0.0_dp, unit='s')
            call arguments%get_threads(settings%threads, misuse)
            call arguments%get('--waveforms', waveforms, misuse, default='sine,tapered,square', &
                               choices=WAVEFORM_NAMES)
            settings%waveform_used = .false.
            do i = 1, size(waveforms)
                settings%waveform_used = settings%waveform_used .or. WAVEFORM_NAMES == waveforms(i)%text
            end do
            call arguments%get('--rods', rods, misuse, default='xyz')
            do i = 1, 3
                settings%rod_used(i) = index(rods, AXES(i)) > 0
            end do
            call refuse_if(verify(rods, 'xyz,') > 0 .or. .not. any(settings%rod_used), &
                           'option --rods: "'//rods//'" has to be one or several of x, y, z', misuse)
        end associate
        call arguments%get('--target-mm', request%plan%target, misuse, default=0.0_dp, low=1e-9_dp, &
                           high=1e3_dp, unit='mm')
        request%plan%target = request%plan%target*MILLIMETRE
        call arguments%get('--reliable', request%reliable, misuse, default=0.0_dp, low=1e-6_dp, high=1e3_dp, unit='mm')
        request%reliable = request%reliable*MILLIMETRE
        call arguments%get('--revolutions', request%plan%revolutions, misuse, default=1, low=1, &
                           high=MOST_REVOLUTIONS)
        call arguments%get('--step', request%map_step, misuse, default=60, low=1, high=3600)
        call arguments%get('--manoeuvres', request%manoeuvres, misuse, default=0, low=1, high=MOST_MANOEUVRES)
        call arguments%get('--out', request%out, misuse, default='')
        call arguments%get('--map', request%map, misuse, default='')
        call check_combination(arguments, misuse)
    end subroutine read_request

    !> Options that contradict each other.
    subroutine check_combination(arguments, misuse)
        type(arguments_t), intent(in) :: arguments
        type(error_t), allocatable, intent(inout) :: misuse

        character(13), parameter :: OF_THE_SEARCH(10) = [character(13) :: '--reliable', '--anywhere', '--everywhere', &
                                                        '--target-mm', '--rods', '--amplitude', &
                                                        '--frequencies', '--waveforms', '--taper', '--rise-time']
        integer :: i

        call refuse_if(arguments%has('--satellite') .and. (arguments%positional_count() > 0 .or. arguments%has('--cases')), &
                       'option --satellite and a CASE exclude each other: a case names its satellite', misuse)
        call refuse_if(arguments%has('--anywhere') .and. (arguments%has('--at') .or. arguments%has('--everywhere')), &
                       'options --at, --anywhere and --everywhere: --anywhere chooses the place itself', misuse)
        call refuse_if(arguments%has('--target-mm') .and. (arguments%has('--anywhere') .or. &
                                                           arguments%has('--everywhere')), &
                       'option --target-mm goes with one place (--at), not with --anywhere or --everywhere', misuse)
        call refuse_if(arguments%has('--reliable') .and. arguments%has('--everywhere'), &
                       'option --reliable goes with one place (--at, --anywhere), not with --everywhere', misuse)
        call refuse_if(arguments%has('--manoeuvre') .and. arguments%has('--pattern'), 'options --manoeuvre and '// &
                       '--pattern exclude each other: each gives the manoeuvre to judge', misuse)
        do i = 1, size(OF_THE_SEARCH)
            call refuse_if(arguments%has('--manoeuvre') .and. arguments%has(trim(OF_THE_SEARCH(i))), 'option '// &
                           trim(OF_THE_SEARCH(i))//' is for the search, and --manoeuvre does not search', misuse)
            call refuse_if(arguments%has('--pattern') .and. arguments%has(trim(OF_THE_SEARCH(i))), 'option '// &
                           trim(OF_THE_SEARCH(i))//' is for the search, and --pattern does not search', misuse)
        end do
    end subroutine check_combination

    !> The case whose orbit it is, with the manoeuvre to judge when one is given.
    subroutine take_cases(arguments, request, calibration, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(request_t), intent(in) :: request
        type(calibration_t), intent(out) :: calibration
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(calibration_t) :: of_manoeuvre
        character(:), allocatable :: satellite, name, manoeuvre, pattern
        real(dp) :: duration, rate, pointing

        call arguments%get('--satellite', satellite, misuse, default='front', choices=SATELLITES)
        call arguments%get('--manoeuvre', manoeuvre, misuse, default='')
        if (allocated(misuse)) return
        name = satellite//'-1'
        if (manoeuvre /= '' .and. .not. arguments%has('--satellite')) name = manoeuvre
        call take_one_calibration(arguments, name, console, calibration, misuse, error, may_rest=.true.)
        if (allocated(misuse) .or. allocated(error)) return
        if (manoeuvre /= '') then
            call take_firing_calibration(arguments, manoeuvre, console, of_manoeuvre, error)
            if (allocated(error)) return
            call take_manoeuvre(of_manoeuvre%case%satellite%rods, calibration%case%satellite%rods)
            calibration%case%duration = of_manoeuvre%case%duration
        end if
        call arguments%get('--duration', duration, misuse, default=calibration%case%duration, low=SHORTEST_ARC, &
                           high=LONGEST_ARC, unit='s')
        call arguments%get('--rate-limit', rate, misuse, default=calibration%case%limits%rate/DEGREE, low=1e-6_dp, &
                           high=1e3_dp, unit='deg/s')
        call arguments%get('--pointing-limit', pointing, misuse, default=calibration%case%limits%pointing/DEGREE, &
                           low=1e-6_dp, high=180.0_dp, unit='deg')
        calibration%case%duration = duration
        if (arguments%has('--pattern')) then
            call arguments%get('--pattern', pattern, misuse, choices=PATTERN_RULES)
            if (.not. allocated(misuse)) call rods_at_place(calibration%case, pattern, request%plan%time, &
                                                            request%plan%revolutions, calibration%case%satellite%rods, error)
            if (allocated(misuse) .or. allocated(error)) return
        end if
        if (arguments%has('--rate-limit')) calibration%case%limits%rate = rate*DEGREE
        if (arguments%has('--pointing-limit')) calibration%case%limits%pointing = pointing*DEGREE
    end subroutine take_cases

    !> The manoeuvre at its place (first) and along the orbit.
    subroutine map_places(request, plan, points, error, console)
        type(request_t), intent(in) :: request
        type(plan_t), intent(in) :: plan
        type(map_point_t), allocatable, intent(out) :: points(:)
        type(error_t), allocatable, intent(out) :: error
        type(console_t), intent(inout) :: console

        real(dp), allocatable :: times(:)

        times = [plan%time]
        if (request%map /= '' .or. request%plan%place == EVERYWHERE .or. request%manoeuvres > 0) &
            times = [times, times_along(plan%orbit, real(request%map_step, dp))]
        call map_manoeuvre(plan%arc, plan%orbit, times, plan%design%rods, request%plan%settings%threads, points, &
                           error, console)
    end subroutine map_places

    subroutine show(request, plan, points, pair, console)
        type(request_t), intent(in) :: request
        type(plan_t), intent(in) :: plan
        type(map_point_t), intent(in) :: points(:)
        type(leakage_pair_t), intent(in), optional :: pair      !! With a second flight; absent: there are many places
        type(console_t), intent(inout) :: console

        type(manoeuvre_design_t) :: other
        character(160) :: row

        write (row, '(a, f4.1, a, f5.1, a)') trim(plan%calibration%case%satellite%name)//' satellite, '// &
            time_of(plan%calibration%case, points(1))//' UTC, '//integer_text(nint(points(1)%time))//' s after the epoch (', &
            abs(points(1)%latitude)/DEGREE, merge(' N, ', ' S, ', points(1)%latitude >= 0), abs(points(1)%longitude)/DEGREE, &
            merge(' E)', ' W)', points(1)%longitude >= 0)//', an arc of '//real_text(plan%arc%knowledge%duration)//' s'
        call console%paragraph(row)
        call console%line('')
        call show_rods(plan%design%rods, console)
        call console%line('')
        call console%line('errors of the CG offset, mm, body axes')
        if (request%plan%place == EVERYWHERE) then
            call show_quality('worst of '//integer_text(size(plan%sites))//' places', plan%design, console)
        else
            call show_quality('this manoeuvre', plan%design, console)
        end if
        if (request%plan%search) then
            call judge_manoeuvre(plan%arc, plan%sites, pattern_567(request%plan%settings, &
                                                                   plan%arc%knowledge%duration), &
                                 size(plan%sites), other)
            call show_quality('5, 6, 7 cycles, for comparison', other, console)
        end if
        call console%line('')
        write (row, '(a, f7.4, a, f7.4, a, f8.4, a, f7.4, a)') 'greatest angular velocity', plan%design%rate/DEGREE, &
            ' deg/s (limit', plan%arc%knowledge%limits%rate/DEGREE, '); turn away from the attitude', &
            plan%design%excursion/DEGREE, ' deg (limit', plan%arc%knowledge%limits%pointing/DEGREE, ')'
        call console%paragraph(row)
        if (request%plan%search) &
            call console%line(integer_text(plan%design%evaluations)//' evaluations of a manoeuvre at a place')
        if (present(pair)) call show_leakage(pair, plan%calibration%case, console)
        if (size(points) > 1) call show_map(plan%calibration%case, points(2:), plan%orbit%revolutions, console)
        if (request%out /= '') then
            call console%line('')
            if (request%plan%search) &
                call console%paragraph(request%out//' has `optimal` estimate scale factors and magnetometer bias, too: '// &
                                       'else they would be the largest errors')
            call console%line('next: gracecg simulate '//quoted_word(request%out)//' --out run1')
        end if
    end subroutine show

    subroutine show_rods(rods, console)
        type(torque_rods_t), intent(in) :: rods
        type(console_t), intent(inout) :: console

        character(120) :: row
        integer :: i

        call console%line('rod  waveform  amplitude, A m^2  frequency, Hz  phase, deg   start     stop, s')
        do i = 1, rods%count
            associate (rod => rods%activations(i))
                write (row, '(a, t6, a, f17.3, f15.6, f12.2, f8.2, f9.2)') AXES(rod%axis), &
                    WAVEFORM_NAMES(rod%waveform), rod%amplitude, rod%frequency, rod%phase/DEGREE, rod%start, &
                    rod%stop
                call console%line(trim(row))
            end associate
        end do
    end subroutine show_rods

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
        call table%column('x_mm', 'f10.5', 'x')
        call table%column('y_mm', 'f10.5', 'y')
        call table%column('z_mm', 'f10.5', 'z')
        call table%add('limit: sigma by the noise of the accelerometer')
        call table%add(design%sigma/MILLIMETRE)
        call table%add('error by the density wave')
        call table%add(design%wave/MILLIMETRE)
        call table%add('error by curved drag and radiation')
        call table%add(design%force/MILLIMETRE)
        call table%add('all together, worst axis')
        call table%add(design%worst/MILLIMETRE)
        call table%add_nothing()
        call table%add_nothing()
        call console%table(table)
    end subroutine show_quality

    !> The best and the worst place of a map.
    subroutine show_map(case, points, revolutions, console)
        type(case_t), intent(in) :: case
        type(map_point_t), intent(in) :: points(:)
        integer, intent(in) :: revolutions
        type(console_t), intent(inout) :: console

        character(120) :: row
        real(dp) :: greatest(size(points))
        integer :: i, place

        call console%line('')
        call console%line('map: '//integer_text(size(points))//' places of '// &
                          integer_text(revolutions)//trim(merge(' revolution ', ' revolutions', revolutions == 1)))
        call console%line('             time, s  UTC                  lat.     long.  sigma x        y        z  greatest, mm')
        do i = 1, size(points)
            greatest(i) = maxval(points(i)%quality%sigma)
        end do
        do i = 1, 2
            place = merge(minloc(greatest, 1), maxloc(greatest, 1), i == 1)
            associate (point => points(place))
                write (row, '(a, t13, i8, 2x, a19, f6.1, f10.1, 4f9.5)') merge('best place ', 'worst place', i == 1), &
                    nint(point%time), time_of(case, point), point%latitude/DEGREE, point%longitude/DEGREE, &
                    min(point%quality%sigma, 99.0_dp)/MILLIMETRE, min(point%worst_sigma, 99.0_dp)/MILLIMETRE
                call console%line(trim(row))
            end associate
        end do
    end subroutine show_map

    !> The time of a place in UTC.
    function time_of(case, point) result(text)
        type(case_t), intent(in) :: case            !! From whose epoch the time counts
        type(map_point_t), intent(in) :: point
        character(:), allocatable :: text

        text = utc_text(utc_plus(case%epoch, point%time))
    end function time_of

    !> All but the time.
    pure function quality_values(point) result(values)
        type(map_point_t), intent(in) :: point
        real(dp) :: values(17)

        associate (quality => point%quality)
            values = [point%latitude/DEGREE, point%longitude/DEGREE, quality%sigma/MILLIMETRE, &
                      point%worst_sigma/MILLIMETRE, point%worst_direction, quality%wave/MILLIMETRE, &
                      quality%force/MILLIMETRE, quality%motion%rate/DEGREE, quality%motion%excursion/DEGREE]
        end associate
    end function quality_values

    !> The manoeuvre at its places, a row each.
    function quality_table(points, case, named) result(table)
        type(map_point_t), intent(in) :: points(:)
        type(case_t), intent(in) :: case            !! From whose epoch the times count
        logical, intent(in) :: named                !! The case's name goes first
        type(data_table_t) :: table

        integer :: i

        if (named) call table%column('case')
        call table%columns_of(QUALITY_COLUMNS)
        do i = 1, size(points)
            if (named) call table%add(case%name)
            call table%add(points(i)%time)
            call table%add(time_of(case, points(i)))
            call table%add(quality_values(points(i)))
        end do
    end function quality_table

    !> The plan as CSV or JSON.
    subroutine publish(plan, points, pair, reliable, candidates, programme, console, error)
        type(plan_t), intent(in) :: plan
        type(map_point_t), intent(in) :: points(:)      !! The place of the manoeuvre, then the map
        type(leakage_pair_t), intent(in), optional :: pair      !! With a second flight
        type(reliable_design_t), intent(in), optional :: reliable       !! If it was asked for
        type(candidate_t), allocatable, intent(in) :: candidates(:)     !! Of a programme; not allocated: none was asked for
        type(programme_t), intent(in) :: programme
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(results_t) :: results
        type(data_table_t) :: map
        integer :: i

        call results%open('design')
        associate (case => plan%calibration%case)
            call results%member('case', trim(case%name))
            call results%member('satellite', trim(case%satellite%name))
            call results%member('epoch_utc', utc_text(case%epoch))
        end associate
        call results%member('duration_s', plan%arc%knowledge%duration)
        call results%member('evaluations', plan%design%evaluations)
        call results%begin('limits')
        call results%member('rate_deg_s', plan%arc%knowledge%limits%rate/DEGREE)
        call results%member('pointing_deg', plan%arc%knowledge%limits%pointing/DEGREE)
        call results%end()
        call results%begin_array('rods')
        do i = 1, plan%design%rods%count
            associate (rod => plan%design%rods%activations(i))
                call results%begin(on_one_line=.true.)
                call results%member('axis', AXES(rod%axis))
                call results%member('waveform', trim(WAVEFORM_NAMES(rod%waveform)))
                call results%member('amplitude_a_m2', rod%amplitude)
                call results%member('frequency_hz', rod%frequency)
                call results%member('phase_deg', rod%phase/DEGREE)
                call results%member('start_s', rod%start)
                call results%member('stop_s', rod%stop)
                call results%end()
            end associate
        end do
        call results%end()
        if (present(pair)) call put_leakage(pair, results)
        if (present(reliable)) call put_reliable(reliable, results)
        map = quality_table(points(2:), plan%calibration%case, .false.)
        call map%to_json(results, 'map')
        if (allocated(candidates)) call put_programme(candidates, programme, results)
        call results%publish(quality_table(points(:1), plan%calibration%case, .true.), console, error)
    end subroutine publish

    subroutine write_map(request, case, points, error)
        type(request_t), intent(in) :: request
        type(case_t), intent(in) :: case
        type(map_point_t), intent(in) :: points(:)
        type(error_t), allocatable, intent(out) :: error

        type(data_table_t) :: table

        table = quality_table(points, case, .false.)
        call table%write(request%map, &
                         [character(160) :: 'gracecg '//VERSION//' design', trim(case%satellite%name)// &
                          ' satellite, orbit of case '//trim(case%name)//' from '// &
                          utc_text(case%epoch)//', a calibration of '//real_text(case%duration)// &
                          ' s at every place', 'sigma: theoretical limit; wave, force: errors by the density '// &
                          'wave and by curved drag and radiation; body axes'], error)
    end subroutine write_map

    !> The case with the manoeuvre, at its place.
    subroutine write_case(request, plan, error)
        type(request_t), intent(in) :: request
        type(plan_t), intent(in) :: plan
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(:), allocatable :: text

        call calibration_text(planned_calibration(request%plan, plan), text, error)
        if (.not. allocated(error)) call file%open(request%out, error)
        if (allocated(error)) return
        call file%line(text)
        call file%commit(error)
    end subroutine write_case
end module gracecg_cli_design
