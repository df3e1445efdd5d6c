!> gracecg timing: the best time for a calibration, Figures 6.1 and 6.4 of CSR-TM-00-01.
module gracecg_cli_timing
    use gracecg_files_value, only: real_from_text
    use gracecg_spacecraft_rod_pattern, only: PATTERN_RULES, AS_DRIVEN
    use gracecg_planning_programme, only: candidate_t, programme_t, candidates_along, best_programme, MOST_MANOEUVRES
    use gracecg_studies_timing, only: timing_study_t, study_timing, weakest_x, best_places, places_table, marked_places_table
    use gracecg_cli_plan_results, only: add_programme
    use gracecg_cli_work
    implicit none
    private
    public :: declare_timing, run_timing

    integer, parameter :: LONGEST_STEP = 600        !! s

    !> A programme that is asked for, and what was found.
    type :: request_t
        integer :: manoeuvres = 0               !! 0: none
        real(dp), allocatable :: lengths(:)     !! s
        type(candidate_t), allocatable :: candidates(:)
        type(programme_t) :: programme
    end type request_t

contains

    !> Arguments and help of `gracecg timing`.
    subroutine declare_timing(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('timing', '[CASE]', 0, 1, &
                                'Finds the best time for a calibration: over one revolution from the epoch of '// &
                                'a case (default front-1), '// &
                                'the geomagnetic field in body axes (Figure 6.1 of CSR-TM-00-01), the '// &
                                'amplitude of the angular acceleration that the rods give (Figure 6.4): as the case drives '// &
                                'them, or, by a rule, as strongly, as fast and as long as its strongest rod, '// &
                                'and the predicted standard deviation of the CG offset.', &
                                'gracecg timing front-1 --step 60 --out timing.csv'//new_line('a')// &
                                'gracecg timing front-1 --step 120 --manoeuvres 2 --lengths 60,120')
        call add_study_options(arguments, '--cases')
        call arguments%add_option('--pattern', 'NAME', 'rule of section 4.2 that chooses the two rods at each place, in place '// &
                                  'of the case''s: y-z, as in the report, or general; driven: the rods as the case drives '// &
                                  'them', choices=PATTERN_RULES)
        call arguments%add_option('--step', 'S', 'whole seconds from place to place', default='10')
        call arguments%add_option('--manoeuvres', 'N', 'the best programme of so many manoeuvres together, at these places')
        call arguments%add_option('--lengths', 'LIST', 'of --manoeuvres: arcs to choose from, s (default: that of the case)')
        call add_study_options(arguments, '--threads --out --format --options')
    end subroutine declare_timing

    !> The work of `gracecg timing`.
    subroutine run_timing(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(study_t) :: asked
        type(timing_study_t) :: study
        character(:), allocatable :: pattern
        type(request_t) :: request
        integer :: step

        call arguments%get('--pattern', pattern, misuse)
        call arguments%get('--step', step, misuse, low=1, high=LONGEST_STEP)
        call read_request(arguments, request, misuse)
        call take_study(arguments, 'front-1', console, asked, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        if (pattern /= '') asked%calibrations(1)%case%pattern_rule = pattern
        call study_timing(asked%calibrations(1), step, asked%threads, study, error, console)
        if (allocated(error)) return
        call show_table(study, console)
        call console%line('')
        call console%line('angular acceleration smaller about x than about y and z: '// &
                          integer_text(weakest_x(study))//' s of the revolution')
        if (request%manoeuvres > 0) then
            if (size(request%lengths) == 0) request%lengths = [study%case%duration]
            call tell(console, 'information of the manoeuvres')
            call candidates_along(study%case, study%orbit, real(study%places%time, dp), request%lengths, asked%threads, &
                                  request%candidates, error, console)
            if (allocated(error)) return
            call best_programme(request%candidates, request%manoeuvres, request%programme)
        end if
        call publish(study, request, asked%path, console, error)
    end subroutine run_timing

    !> What is asked of a programme.
    subroutine read_request(arguments, request, misuse)
        type(arguments_t), intent(in) :: arguments
        type(request_t), intent(out) :: request
        type(error_t), allocatable, intent(inout) :: misuse

        type(string_t), allocatable :: words(:)
        character(:), allocatable :: problem
        integer :: i

        call arguments%get('--manoeuvres', request%manoeuvres, misuse, low=1, high=MOST_MANOEUVRES)
        call arguments%get('--lengths', words, misuse)
        call refuse_if(request%manoeuvres == 0 .and. size(words) > 0, '--lengths belongs to --manoeuvres N', misuse)
        allocate (request%lengths(size(words)))
        do i = 1, size(words)
            call real_from_text(words(i)%text, request%lengths(i), problem, 6.0_dp, 3600.0_dp, 's')
            if (allocated(problem)) call refuse_if(.true., '--lengths: '//problem, misuse)
        end do
    end subroutine read_request

    !> All places as CSV or JSON, and into the file.
    subroutine publish(study, request, path, console, error)
        type(timing_study_t), intent(in) :: study
        type(request_t), intent(in) :: request
        character(*), intent(in) :: path        !! Of the file; empty: none
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        character(3), parameter :: OF_WHAT(4) = [character(3) :: 'x', 'y', 'z', 'all']
        type(results_t) :: results
        type(data_table_t) :: of_cases
        integer :: i

        call results%open('timing')
        call results%member('satellite', trim(study%case%satellite%name))
        call results%member('epoch_utc', utc_text(study%case%epoch))
        call results%member('duration_s', study%case%duration)
        call results%member('revolution_s', study%orbit%revolution)
        call results%member('step_s', study%step)
        call results%member('pattern', trim(study%case%pattern_rule))
        of_cases = places_table(study%of_cases, study%case%epoch)
        call of_cases%to_json(results, 'cases')
        call results%begin('best_places')
        associate (best => best_places(study%places))
            do i = 1, size(best)
                call results%member(trim(OF_WHAT(i))//'_time_s', study%places(best(i))%time)
                call results%member(trim(OF_WHAT(i))//'_utc', utc_text(utc_plus(study%case%epoch, &
                                                                                real(study%places(best(i))%time, dp))))
            end do
        end associate
        call results%end()
        call results%member('weakest_about_x_s', weakest_x(study))
        if (request%manoeuvres > 0) &
            call add_programme(request%candidates, request%programme, console, results)
        call results%publish(places_table(study%places, study%case%epoch), console, error, path, &
                             trim(study%case%satellite%name)//' satellite; field in body axes')
    end subroutine publish

    !> The places of the report's cases and the best ones.
    subroutine show_table(study, console)
        type(timing_study_t), intent(in) :: study
        type(console_t), intent(inout) :: console

        character(:), allocatable :: rods

        call console%paragraph(trim(study%case%satellite%name)//' satellite: one revolution of '// &
                               integer_text(nint(study%orbit%revolution))//' s from '//utc_text(study%case%epoch)// &
                               ', a calibration of '//integer_text(nint(study%case%duration))//' s at every '// &
                               integer_text(study%step)//' s')
        rods = 'rods as the case drives them'
        if (study%case%pattern_rule /= AS_DRIVEN) rods = 'rods by the rule '//trim(study%case%pattern_rule)//', not as the '// &
                                                         'case drives them'
        call console%paragraph(rods//'; field in body axes; '// &
                               'amplitude of the angular acceleration; predicted sigma of the CG offset by assest-fde (the '// &
                               'limit of any estimator: gracecg bound)')
        call console%line('')
        call console%table(marked_places_table(study))
        call console%line('(best x: the least sigma of x; best all: the largest of the three is least)')
    end subroutine show_table
end module gracecg_cli_timing
